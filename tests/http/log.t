#!/usr/bin/perl
# The log: whoever reads it late or never stops nothing, and whatever strangers send stays inside its line.
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use POSIX ();
use Test::More;
use Vt;

# A daemon whose standard error is a pipe of one page; it and the end to read from.
sub start_on_a_pipe {
    pipe my $reader, my $writer or die "pipe: $!";
    fcntl $writer, 1031, 4096 or die "F_SETPIPE_SZ: $!";
    my $dir = tempdir(CLEANUP => 1);
    open my $keep, '>&', \*STDERR or die "dup: $!";
    open STDERR, '>&', $writer or die "dup: $!";
    my $pid = fork // die "fork: $!";
    if (!$pid) {
        exec $ENV{VORONOID} // 'build/release/voronoid', 'serve', '--listen', '127.0.0.1:0', '--data', "$dir/data",
            '--threads', 1
            or POSIX::_exit(127);
    }
    open STDERR, '>&', $keep or die "dup: $!";
    close $writer;
    my $text = '';
    sysread $reader, $text, 4096, length $text or die 'the daemon ended' until $text =~ /"address":"([^"]+)"/;
    my $self = bless { pid => $pid, address => $1, url => "http://$1", dir => $dir }, 'Vt';
    ($self->{port}) = $1 =~ /:(\d+)$/;
    $self->{http} = HTTP::Tiny->new(timeout => $Vt::PATIENCE, max_redirect => 0);
    return ($self, $reader);
}

# A page holds some twelve lines of requests.
my ($silent, $reader) = start_on_a_pipe();
my $answered = grep { $silent->get('/livez')->{status} == 200 } 1 .. 60;
is $answered, 60, 'a log that nobody reads stops no request';
is $silent->stop, 0, 'nor the end of the daemon';

($silent, $reader) = start_on_a_pipe();
$silent->get('/livez') for 1 .. 60;
kill 'TERM', $silent->{pid};
my $rest = Vt::read_all($reader);
is Vt::reap(delete $silent->{pid}), 0, 'one that is read late is ended too';
is scalar(() = $rest =~ m{"route":"/livez"}g), 60, 'and not a line of it is lost';
like $rest, qr/"msg":"stopped","exit":0\}\n\z/, 'up to the last';

# What strangers send: a line is one JSON object whatever comes in, and nothing raw is in a head or a line.
my $daemon = Vt->start(jobs => 1, 'log-level' => 'debug');
my @evil = ("\r\nX-Evil: 1", "\e[31m\x07", "\"},{\"level\":\"error\"", "\xff\xfe\xc0\xaf", "\xe2\x80\xae\x7f", 'x' x 7000, '%00%0d%0a%1b[2J',
    "\\u0000\\", "\0");
my @heads;
for my $evil (@evil) {
    my $escaped = $evil =~ s/([^A-Za-z0-9])/sprintf '%%%02X', ord $1/ger;
    for my $request ("GET /$escaped HTTP/1.1\r\n", "GET /v1/jobs?status=$escaped HTTP/1.1\r\n", "GET /v1/jobs/$escaped/events HTTP/1.1\r\n",
        "GET /v1/jobs HTTP/1.1\r\nX-Request-Id: $evil\r\n", "GET /v1/jobs HTTP/1.1\r\ntraceparent: $evil\r\n", "$evil /livez HTTP/1.1\r\n",
        "POST /v1/resample?points=$escaped&name=$escaped HTTP/1.1\r\nContent-Length: 2\r\n",
        "POST /v1/processes/resample/execution HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: "
            . (length($evil) + 20) . "\r\n", "GET /livez HTTP/1.1\r\nOrigin: $evil\r\nX-Forwarded-For: $evil\r\n",
        "POST /v1/resample HTTP/1.1\r\nContent-Type: multipart/form-data; boundary=b\r\nTransfer-Encoding: chunked\r\n") {
        my $form = "--b\r\nContent-Disposition: form-data; name=\"$evil\"; filename=\"$evil\"\r\n\r\n1\r\n--b--\r\n";
        my $body = $request =~ /json/ ? "{\"inputs\":{\"name\":\"$evil\"" : $request =~ /POST/ ? 'xx' : '';
        $body = sprintf "%x\r\n%s\r\n0\r\n\r\n", length $form, $form if $request =~ /multipart/;
        my $socket = $daemon->connect;
        $socket->syswrite("${request}Host: $daemon->{address}\r\nConnection: close\r\n\r\n$body");
        shutdown $socket, 1;
        push @heads, head_of(Vt::read_all($socket));
    }
}
is $daemon->get('/livez')->{status}, 200, 'the daemon answers after all of it';
is scalar(grep { /[^\r\n\x20-\x7e]/ } @heads), 0, 'no head of an answer holds a raw byte of theirs';
is scalar(grep { /^X-Evil/mi } @heads), 0, 'nor a field of theirs';
my (@bad, @long);
for my $line (split /\n/, $daemon->log_text) {
    push @bad, $line unless eval { ref JSON::PP::decode_json($line) eq 'HASH' } && $line !~ /[\x00-\x1f\x7f]/;
    push @long, length $line if length $line > 2048;
}
is scalar(@bad), 0, 'every line of the log is one JSON object without control bytes' or diag $bad[0];
is "@long", '', 'and none is long';
cmp_ok scalar(grep { /"msg":"request"/ } split /\n/, $daemon->log_text), '>=', 60, 'of many';

# A trace: what asked for a job is in its lines, also after a new start.
my $trace = '4bf92f3577b34da6a3ce929d0e0e4736';
my $answer = $daemon->post('/v1/resample?points=4000&iterations=10000&polish=0', sphere_ply(4000), Prefer => 'respond-async',
    traceparent => "00-$trace-00f067aa0ba902b7-01", 'X-Request-Id' => 'mine');
my $job = json($answer)->{jobID};
is $answer->{headers}{'x-request-id'}, 'mine', 'the request has the name that its caller gave';
ok wait_until(sub { $daemon->status($job) eq 'running' }), 'the job runs';
ok wait_until(sub { $daemon->log_text =~ /"job started"/ }), 'and the log says so';
my ($asked) = grep { ($_->{request_id} // '') eq 'mine' } $daemon->log_lines;
is $asked->{trace_id}, $trace, 'its line has the trace';
like $asked->{span_id}, qr/^(?!00f067aa0ba902b7)[0-9a-f]{16}$/, 'and a step of our own';
is $asked->{job}, $job, 'and the job';
for my $of (grep { ($_->{msg} // '') =~ /^job (?:accepted|started)$/ } $daemon->log_lines) {
    is "$of->{job} $of->{trace_id} $of->{span_id}", "$job $trace $asked->{span_id}", "so has \"$of->{msg}\"";
}
$daemon->stop('KILL');
my $again = Vt->start(dir => $daemon->{dir}, jobs => 1);
ok wait_until(sub { $again->log_text =~ /"job started"/ }), 'after a crash it is started again';
my ($started) = grep { ($_->{msg} // '') eq 'job started' } $again->log_lines;
is "$started->{trace_id} $started->{span_id}", "$trace $asked->{span_id}", 'in the same trace';
for my $none ('nonsense', "00-$trace-0000000000000000-01", "ff-$trace-00f067aa0ba902b7-01") {
    $again->{http}->get("$again->{url}/livez", { headers => { traceparent => $none, 'X-Request-Id' => 'none' } });
}
ok wait_until(sub { 3 == grep { ($_->{request_id} // '') eq 'none' } $again->log_lines }), 'what is no traceparent';
is scalar(grep { ($_->{request_id} // '') eq 'none' && exists $_->{trace_id} } $again->log_lines), 0, 'is ignored';
$again->get("/v1/jobs/$job");
$again->request('DELETE', "/v1/jobs/$job");
is $again->stop, 0, 'it ends';

done_testing();
