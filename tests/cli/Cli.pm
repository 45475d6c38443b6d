package Cli;

# What the command line's tests share: running the binary, small clouds, a daemon of our own.
use strict;
use warnings;
use Exporter 'import';
use File::Temp qw(tempdir);
use IO::Select;
use IO::Socket::INET;
use POSIX qw(:sys_wait_h);
use Time::HiRes qw(sleep time);

our @EXPORT = qw(run start finish slurp spew scratch sphere leftovers shared daemon stop cutter await);

my $PATIENCE = 120; # seconds that anything is waited for; they decide nothing
my $binary = $ENV{VORONOID} // 'build/release/voronoid';
$binary = "$ENV{PWD}/$binary" unless $binary =~ m{^/};
delete @ENV{qw(VORONOID_SERVER VORONOID_THREADS http_proxy HTTP_PROXY all_proxy ALL_PROXY)};

# What a test that dies leaves running goes with it.
my ($owner, %running) = ($$);
END {
    local $?;
    if ($$ == $owner) {
        kill 'KILL', $_ for keys %running;
    }
}

sub forget { delete $running{ $_[0] } }

# A folder that goes away with the test.
sub scratch { return tempdir('voronoid-cli-XXXXXX', TMPDIR => 1, CLEANUP => 1) }

sub slurp {
    my ($path) = @_;
    open my $file, '<:raw', $path or die "$path: $!";
    local $/;
    my $bytes = <$file>;
    return $bytes // '';
}

sub spew {
    my ($path, $bytes) = @_;
    open my $file, '>:raw', $path or die "$path: $!";
    print $file $bytes;
    close $file or die "$path: $!";
    return $path;
}

# Starts the binary with arguments; stdin is a file. Its output goes to files beside each other.
sub start {
    my ($arguments, %with) = @_;
    my $folder = scratch();
    spew("$folder/err", '');
    my $pid = fork // die "fork: $!";
    if ($pid == 0) {
        $ENV{$_} = $with{env}{$_} for keys %{ $with{env} // {} };
        open STDIN, '<', $with{stdin} // '/dev/null' or die;
        open STDOUT, '>', $with{stdout} // "$folder/out" or die;
        open STDERR, '>', "$folder/err" or die;
        exec { $binary } $binary, @$arguments or die "$binary: $!";
    }
    $running{$pid} = 1;
    return { pid => $pid, folder => $folder };
}

# Waits for it: exit code (128 + signal when it died of one), stdout, stderr.
sub finish {
    my ($process, $seconds) = @_;
    my $until = time + ($seconds // $PATIENCE);
    while (waitpid($process->{pid}, WNOHANG) == 0) {
        if (time > $until) {
            kill 'KILL', $process->{pid};
            waitpid $process->{pid}, 0;
            last;
        }
        sleep 0.01;
    }
    delete $running{ $process->{pid} };
    my $code = $? & 127 ? 128 + ($? & 127) : $? >> 8;
    my $out = -e "$process->{folder}/out" ? slurp("$process->{folder}/out") : '';
    return ($code, $out, slurp("$process->{folder}/err"));
}

sub run {
    my ($arguments, %with) = @_;
    return finish(start($arguments, %with));
}

# Asks again and again until the answer is true; the answer, or nothing after two minutes.
sub await(&) {
    my ($question) = @_;
    my $until = time + $PATIENCE;
    while (time < $until) {
        my $answer = $question->();
        return $answer if $answer;
        sleep 0.01;
    }
    return;
}

# A daemon of our own on a free port (or the one given) of this machine.
sub daemon {
    my ($data, $listen, @settings) = @_;
    my $process = start(['serve', '--listen', $listen, '--data', $data, @settings]);
    my $address = await { slurp("$process->{folder}/err") =~ /"address":"([^"]+)"/ ? $1 : undef };
    die 'no daemon: ' . slurp("$process->{folder}/err") unless $address;
    return { %$process, address => $address, url => "http://$address" };
}

sub stop {
    my ($daemon, $signal) = @_;
    kill $signal // 'TERM', $daemon->{pid};
    return finish($daemon);
}

# One connection through a cutter: bytes from one side to the other until a side closes, or until an
# event stream that is to be cut has given `most` bytes. Requests come one after another, so each
# begins a piece.
sub relay {
    my ($near, $far, $log, $cuts, $most) = @_;
    my ($select, $left) = (IO::Select->new($near, $far), undef);
    while (1) {
        for my $from ($select->can_read) {
            return unless sysread $from, my $bytes, $left // 65536;
            if ($from == $near && $bytes =~ m{^GET \S+/events } && (my @cut = split /\n/, slurp($log)) < $cuts) {
                my ($last) = $bytes =~ /^Last-Event-ID: (\S+)/mi;
                spew($log, join "\n", @cut, $last // 'none');
                $left = $most;
            }
            syswrite $from == $near ? $far : $near, $bytes;
            $left -= length $bytes if $from == $far && defined $left;
            return if defined $left && $left <= 0;
        }
    }
}

# A way to a daemon that cuts the first `cuts` event streams after `most` bytes. The Last-Event-ID of
# each stream that was cut is noted in the file `log`, a line each.
sub cutter {
    my ($address, $cuts, $most) = @_;
    my $log = scratch() . '/log';
    my $listener = IO::Socket::INET->new(LocalAddr => '127.0.0.1', Listen => 16, Proto => 'tcp') or die;
    spew($log, '');
    my $pid = fork // die "fork: $!";
    if ($pid == 0) {
        $SIG{CHLD} = 'IGNORE';
        while (my $near = $listener->accept) {
            next if fork;
            my $far = IO::Socket::INET->new(PeerAddr => $address, Proto => 'tcp') or POSIX::_exit(0);
            relay($near, $far, $log, $cuts, $most);
            POSIX::_exit(0);
        }
        POSIX::_exit(0);
    }
    $running{$pid} = 1;
    return { pid => $pid, url => 'http://127.0.0.1:' . $listener->sockport, log => $log };
}

# n points on the unit sphere as an ascii PLY, coordinates exact in float32; the same for the same
# n and seed.
sub sphere {
    my ($n, $seed) = @_;
    my $state = ($seed // 1) * 2654435761 % 4294967296;
    my $random = sub {
        $state = ($state * 1664525 + 1013904223) % 4294967296;
        return $state / 4294967296;
    };
    my $text = "ply\nformat ascii 1.0\nelement vertex $n\nproperty float x\nproperty float y\n"
        . "property float z\nend_header\n";
    for (1 .. $n) {
        my ($z, $a) = (2 * $random->() - 1, 6.283185307179586 * $random->());
        my $r = sqrt(1 - $z * $z);
        $text .= sprintf "%.9g %.9g %.9g\n", unpack 'f3', pack 'f3', $r * cos $a, $r * sin $a, $z;
    }
    return $text;
}

# Names in a folder that we did not put there.
sub leftovers {
    my ($folder, @known) = @_;
    opendir my $dir, $folder or die "$folder: $!";
    my %known = map { $_ => 1 } '.', '..', @known;
    return join ' ', sort grep { !$known{$_} } readdir $dir;
}

# A path in ../shared when it is there.
sub shared {
    my ($path) = @_;
    return "../shared/$path" if -e "../shared/$path";
    die "../shared/$path is not there, and CI is set: its tests must run\n" if $ENV{CI};
    return undef;
}

1;
