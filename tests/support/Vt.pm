# What the HTTP tests share: a real daemon on a free port with a directory of its own, raw and polite
# requests, a reader of event streams, and clouds.
package Vt;
use strict;
use warnings;
use Cwd qw(abs_path);
use Exporter 'import';
use File::Temp qw(tempdir);
use HTTP::Tiny;
use IO::Select;
use IO::Socket::INET;
use JSON::PP ();
use POSIX ();
use Time::HiRes qw(time sleep);

our @EXPORT = qw(spew sphere_ply json is_problem refused wait_until head_of body_of data_file);

# Seconds that anything is waited for. It bounds a test that goes wrong, and decides nothing.
our $PATIENCE = 120;

my $OGC = 'http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0';
our $binary = abs_path($ENV{VORONOID} // 'build/release/voronoid');
my %running;

# Starts a daemon and waits until it listens. Settings are pairs; dir => keeps a directory of before.
sub start {
    my ($class, %settings) = @_;
    my $dir = delete $settings{dir} // tempdir(CLEANUP => 1);
    my $self = bless { dir => $dir, log => "$dir/log." . (++$Vt::count) }, $class;
    my @arguments = ('--listen', '127.0.0.1:0', '--data', "$dir/data", '--threads', 2);

    push @arguments, "--$_=$settings{$_}" for sort keys %settings;
    $self->{pid} = spawn($self->{log}, @arguments);
    $running{ $self->{pid} } = 1;
    $self->{address} = wait_until(
        sub {
            if (waitpid($self->{pid}, POSIX::WNOHANG()) > 0) {
                delete $running{ delete $self->{pid} };
                die 'the daemon ended: ' . $self->log_text;
            }
            $self->log_text =~ /"msg":"listening","address":"([^"]+)"/ ? $1 : undef;
        }) or die 'the daemon does not listen' . standing($self->{pid}) . ': ' . $self->log_text;
    ($self->{port}) = $self->{address} =~ /:(\d+)$/;
    ($self->{admin}) = $self->log_text =~ /"msg":"listening"[^\n]*"admin":"([^"]+)"/;
    $self->{url} = "http://$self->{address}";
    $self->{http} = HTTP::Tiny->new(timeout => $PATIENCE, max_redirect => 0);
    return $self;
}

# The process of `voronoid serve` with these arguments; what it says goes to a file.
sub spawn {
    my ($log, @arguments) = @_;
    my $pid = fork // die "fork: $!";

    return $pid if $pid;
    open STDIN, '<', '/dev/null';
    open STDOUT, '>', "$log.out";
    open STDERR, '>', $log;
    exec { $binary } $binary, 'serve', @arguments or POSIX::_exit(127);
}

# What each thread of a process and its children does, and what it waits for in the kernel: for one that takes too long.
sub standing {
    my ($pid) = @_;
    my @words;
    for my $task (glob "/proc/$pid/task/[0-9]*") {
        my ($name, $state) = slurp("$task/stat") =~ /\((.*)\) (\S)/s or next;
        push @words, "$name $state " . (slurp("$task/wchan") || '?');
        push @words, map { standing($_) =~ s/^, //r } split ' ', slurp("$task/children");
    }
    return join ', ', '', @words;
}

# Runs it to its end: exit status and what it said on standard error.
sub run {
    my (@arguments) = @_;
    my $log = File::Temp->new;
    my $pid = spawn("$log", @arguments);

    waitpid $pid, 0;
    return ($? >> 8, slurp("$log"), slurp("$log.out"));
}

sub slurp {
    my ($path) = @_;
    open my $file, '<:raw', $path or return '';
    local $/;
    return scalar <$file> // '';
}

sub spew {
    my ($path, @bytes) = @_;
    open my $file, '>:raw', $path or die "$path: $!";
    print $file @bytes;
    close $file or die "$path: $!";
    return $path;
}

# The blocks of code that users are shown, in the order printed: those of README.md, then those of the help's topics.
sub documented {
    my @blocks;
    my $readme = slurp('README.md');
    push @blocks, { in => 'README.md', language => $1, text => $2 } while $readme =~ /^```(\w*)\n(.*?)^```$/msg;
    for my $topic (slurp('server/base/topics.h') =~ /^ +X\((\w+), \d\)/mg) {
        my $text = slurp("server/cli/help/$topic.txt");
        while ($text =~ /^%(?!table )(\w*)\n((?:    [^\n]*\n|\n)+)/mg) {
            my ($language, $lines) = ($1, $2);
            push @blocks, { in => $topic, language => $language, text => ($lines =~ s/^    //mgr) =~ s/\n+\z/\n/r };
        }
        # Lines that no word tells the language of would be run by nobody.
        $text =~ s/^%\w+\n(?:    [^\n]*\n|\n)+//mg;
        push @blocks, { in => $topic, language => '', text => $1 } while $text =~ /^\n( {4}(?! ).*)/mg;
    }
    return @blocks;
}

# The text of the first block in a language.
sub documented_in {
    my ($language) = @_;
    my ($block) = grep { $_->{language} eq $language } documented();
    return $block ? $block->{text} : die "nothing that users are shown is $language";
}

# The names of the blobs that a daemon has, in files and in its store, and of what is being written.
sub blobs {
    my ($self) = @_;
    my $small = `sqlite3 $self->{dir}/data/jobs.sqlite 'SELECT name FROM small_file'`;
    die "sqlite3: $?" if $?;
    return map { s{.*/}{}r } (glob "$self->{dir}/data/blobs/keep/* $self->{dir}/data/blobs/tmp/*"), split /\n/, $small;
}

sub log_text { return slurp($_[0]{log}) }

# The lines. A thread of the daemon writes them a little after what they tell of: while it runs they are read once there is
# the line of a request that comes after all others, which is left out. That one is of level info.
sub log_lines {
    my ($self) = @_;
    my $mark = 'mark-of-Vt-' . ++$Vt::marks;

    if (defined $self->{pid} && $self->{http}->get("$self->{url}/livez", { headers => { 'X-Request-Id' => $mark } })->{status} != 599) {
        wait_until(sub { $self->log_text =~ /"\Q$mark\E"[^\n]*\n/ }) or die "the log has no line of $mark";
    }
    return grep { ($_->{request_id} // '') !~ /^mark-of-Vt-/ } map { JSON::PP::decode_json($_) } grep { length } split /\n/, $self->log_text;
}

# The sum of a metric over its labels. Wants admin-listen.
sub metric {
    my ($self, $name) = @_;
    my $sum = 0;
    my $answer = $self->{http}->get("http://$self->{admin}/metrics");

    die "metrics: $answer->{content}" if $answer->{status} != 200;
    $sum += $1 while $answer->{content} =~ /^voronoid_$name(?:\{[^\n]*\})? (\S+)$/mg;
    return $sum;
}

# Waits until so many requests are under way and no thread serves any: they wait for something. Wants admin-listen.
sub wait_asleep {
    my ($self, $requests) = @_;
    return wait_until(sub { $self->metric('http_in_flight_requests') == $requests && $self->metric('http_thread_busy_seconds') == 0 });
}

# Ends it; the exit status, or "signal N".
sub stop {
    my ($self, $signal) = @_;
    my $pid = delete $self->{pid} // return undef;
    kill $signal // 'TERM', $pid;
    return reap($pid);
}

sub reap {
    my ($pid) = @_;
    my $status;

    wait_until(sub { waitpid($pid, POSIX::WNOHANG()) > 0 ? defined($status = $?) : 0 });
    delete $running{$pid};
    return 'still running' unless defined $status;
    return $status & 127 ? 'signal ' . ($status & 127) : $status >> 8;
}

sub DESTROY { local $?; $_[0]->stop('KILL') if $_[0]{pid} } # at the end of the program too, whose status it is not
END { my $status = $?; kill 'KILL', $_ for keys %running; $? = $status }

# Bytes with a change or several, half of them among the first `front`; what is put in is often one of these bits. By srand.
sub mutant {
    my ($bytes, $front, @bits) = @_;
    for (0 .. int rand 4) {
        my $size = length $bytes;
        my $at = int rand(rand() < 0.5 ? $size : $size < $front ? $size : $front);
        my $much = int rand(rand() < 0.8 ? 8 : $size);
        my $how = int rand 6;
        if ($how == 0) { substr($bytes, $at, 1) ^= chr(1 << int rand 8) if $at < $size }
        elsif ($how == 1) { substr($bytes, $at, $much) = '' }
        elsif ($how == 2) { substr($bytes, $at, 0) = substr $bytes, $at, $much }
        elsif ($how == 3) { substr($bytes, $at, 0) = $bits[rand @bits] }
        elsif ($how == 4) { substr($bytes, $at, $much) = $bits[rand @bits] }
        else { $bytes = substr $bytes, 0, $at if rand() < 0.3 }
    }
    return $bytes;
}

# A polite request: HTTP::Tiny's answer.
sub request {
    my ($self, $method, $path, %options) = @_;
    my $answer = $self->{http}->request($method, "$self->{url}$path", \%options);

    die "$method $path: $answer->{content}" if $answer->{status} == 599;
    return $answer;
}
sub get { my $self = shift; return $self->request('GET', @_) }

sub post {
    my ($self, $path, $body, %headers) = @_;
    return $self->request('POST', $path, content => $body, headers => \%headers);
}

# Submits a job; its identifier.
sub submit {
    my ($self, $query, $body) = @_;
    my $answer = $self->post("/v1/resample?$query", $body, Prefer => 'respond-async');

    die "submit: $answer->{status} $answer->{content}" unless $answer->{status} == 201;
    return json($answer)->{jobID};
}

sub status { return json($_[0]->get("/v1/jobs/$_[1]"))->{status} }

# Waits until the job is over; its statusInfo.
sub finish {
    my ($self, $id) = @_;
    my $info;

    wait_until(
        sub {
            $info = json($self->get("/v1/jobs/$id"));
            $info->{status} =~ /^(successful|failed|dismissed)$/;
        }) or die "job $id does not end";
    return $info;
}

sub connect {
    my ($self) = @_;
    return IO::Socket::INET->new(PeerAddr => '127.0.0.1', PeerPort => $self->{port}, Timeout => $PATIENCE)
        // die "connect: $!";
}

# Sends bytes as they are and reads until the other end closes.
sub raw {
    my ($self, $bytes) = @_;
    my $socket = $self->connect;

    $socket->syswrite($bytes);
    return read_all($socket);
}

# Reads until the other end closes, or until what has come is like that.
sub read_all {
    my ($socket, $enough) = @_;
    my $until = time + $PATIENCE;
    my $all = '';

    while ((my $left = $until - time) > 0) {
        next unless IO::Select->new($socket)->can_read($left);
        last unless $socket->sysread($all, 65536, length $all);
        last if defined $enough && $all =~ $enough;
    }
    return $all;
}

# A stream of events: opens it and checks nothing. next_event yields {id,event,data} or undef at its
# end; {head} is the response's head.
sub events {
    my ($self, $path, %options) = @_;
    my $socket = $self->connect;
    my $method = $options{method} // 'GET';
    my $body = $options{body} // '';
    my $stream = bless { socket => $socket, raw => '', text => '' }, 'Vt::Stream';
    my $head = "$method $path HTTP/1.1\r\nHost: $self->{address}\r\n";

    $head .= "$_: $options{headers}{$_}\r\n" for sort keys %{ $options{headers} // {} };
    $head .= 'Content-Length: ' . length($body) . "\r\n" if $method eq 'POST';
    $socket->print("$head\r\n$body");
    $socket->flush;
    $stream->more while $stream->{raw} !~ /\r\n\r\n/ && !$stream->{closed};
    $stream->{raw} =~ s/\A(.*?\r\n)\r\n//s and $stream->{head} = $1;
    $stream->unchunk;
    return $stream;
}

# --- what has no daemon -------------------------------------------------------------------------

sub json { return JSON::PP::decode_json(ref $_[0] ? $_[0]{content} : $_[0]) }
sub head_of { return (split /\r\n\r\n/, $_[0], 2)[0] }
sub body_of { return (split /\r\n\r\n/, $_[0], 2)[1] // '' }

# Asks until the answer is true; it, or undef when the time is over.
sub wait_until {
    my ($question) = @_;
    my $until = time + $PATIENCE;

    while (1) {
        my $answer = $question->();
        return $answer if $answer;
        return undef if time > $until;
        sleep 0.02;
    }
}

# n points on the unit sphere, evenly but for a little noise that depends on nothing.
sub sphere_ply {
    my ($n) = @_;
    my $bytes = "ply\nformat binary_little_endian 1.0\nelement vertex $n\n"
        . "property float x\nproperty float y\nproperty float z\nend_header\n";

    for my $i (0 .. $n - 1) {
        my $z = 1 - 2 * ($i + 0.5) / $n;
        my $angle = $i * 2.399963229728653 + 0.3 * sin($i * 12.9898);
        my $r = sqrt(1 - $z * $z);
        $bytes .= pack 'f<3', $r * cos $angle, $r * sin $angle, $z;
    }
    return $bytes;
}

# A file of ../shared/data, or undef where there is none.
sub data_file {
    my ($name) = @_;
    my $path = "../shared/data/$name";
    return $path if -r $path;
    die "$path is not there, and CI is set: its tests must run\n" if $ENV{CI};
    return undef;
}

# True when an answer is the problem it should be, whole; else says why not.
sub is_problem {
    my ($answer, $status, $slug, $name) = @_;
    my $test = Test::Builder->new;
    my $problem = eval { json($answer) } // {};
    my $ogc = $problem->{type} // '';
    my @wrong;

    push @wrong, "status $answer->{status}, want $status" if $answer->{status} != $status;
    push @wrong, 'type ' . ($problem->{type} // 'none') . ", want $slug"
        unless ($problem->{type} // '') =~ m{/(?:problems|1\.0)/\Q$slug\E\z};
    push @wrong, "member $_ is missing"
        for grep { !defined $problem->{$_} } qw(type title status detail instance retryable requestId);
    push @wrong, 'status member differs' if ($problem->{status} // 0) != $status;
    push @wrong, "media type $answer->{headers}{'content-type'}"
        if $answer->{headers}{'content-type'} ne 'application/problem+json';
    push @wrong, 'requestId is not that of the header'
        if ($problem->{requestId} // '') ne ($answer->{headers}{'x-request-id'} // '-');
    push @wrong, 'retryable without Retry-After'
        if $problem->{retryable} && !defined $answer->{headers}{'retry-after'};
    $test->ok(!@wrong, $name // "$status $slug");
    $test->diag(join '; ', @wrong, substr $answer->{content}, 0, 400) if @wrong;
    return !@wrong;
}

# That, and what it says.
sub refused {
    my ($answer, $status, $slug, $detail, $name) = @_;
    local $Test::Builder::Level = $Test::Builder::Level + 1;
    return is_problem($answer, $status, $slug, $name) && Test::More::like(json($answer)->{detail}, $detail, "$name: it says why");
}

package Vt::Stream;
use Time::HiRes qw(time);

# Reads once more from the socket; false at its end.
sub more {
    my ($self, $seconds) = @_;
    return 0 if $self->{closed};
    return 0 unless IO::Select->new($self->{socket})->can_read($seconds // $Vt::PATIENCE);
    my $got = $self->{socket}->sysread($self->{raw}, 65536, length $self->{raw});
    $self->{closed} = 1 unless $got;
    return $got ? 1 : 0;
}

sub unchunk {
    my ($self) = @_;
    if ($self->{head} !~ /^Transfer-Encoding: chunked/mi) {
        $self->{text} .= $self->{raw};
        $self->{raw} = '';
        return;
    }
    while ($self->{raw} =~ /\A([0-9a-fA-F]+)\r\n/) {
        my ($size, $skip) = (hex $1, length($1) + 2);
        if ($size == 0) { $self->{closed} = $self->{whole} = 1; return }
        return if length $self->{raw} < $skip + $size + 2;
        $self->{text} .= substr $self->{raw}, $skip, $size;
        substr($self->{raw}, 0, $skip + $size + 2) = '';
    }
}

# The next block up to an empty line, parsed; comments and retry appear as {comment}, {retry}.
sub next_block {
    my ($self) = @_;
    my $until = time + $Vt::PATIENCE;

    while ($self->{text} !~ /\n\n/) {
        return undef if $self->{closed} || time > $until;
        $self->more($until - time);
        $self->unchunk;
    }
    $self->{text} =~ s/\A(.*?)\n\n//s;
    my %block;
    for my $line (split /\n/, $1) {
        if ($line =~ /^: ?(.*)/) { $block{comment} = $1 }
        elsif ($line =~ /^(\w+): (.*)/) { $block{$1} = $2 }
    }
    return \%block;
}

sub next_event {
    my ($self) = @_;
    while (my $block = $self->next_block) {
        return $block if defined $block->{event};
    }
    return undef;
}

# Every event up to the end.
sub all {
    my ($self) = @_;
    my @events;
    while (my $event = $self->next_event) { push @events, $event }
    return @events;
}

sub close { close $_[0]{socket}; $_[0]{closed} = 1 }

1;
