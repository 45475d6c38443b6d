#!/usr/bin/perl
# Many streams of events: what each takes of memory, how long /livez waits beside them (idle, and of a job
# that goes on), and how soon everything is back once their readers are gone: closed, and without a word, in a network of their own.
use strict;
use warnings;
BEGIN { @main::ARGV_WAS = @ARGV }
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use POSIX ();
use Socket;
use Time::HiRes qw(sleep time);
use Sockets;
use Vt;

my ($long, $seed) = Sockets::options();
my $files = Sockets::files(12000);
my $streams = $long ? 10000 : 1000;
my $seconds = $long ? 30 : 1;
$streams = $files - 500 if $streams > $files - 500;

sub begin {
    my (%settings) = @_;
    my $daemon = Vt->start(connections => 400, streams => $streams, jobs => 1, threads => 1, %settings);
    my $running = $daemon->submit('points=5000&iterations=10000&polish=0', sphere_ply(20000));
    my $waiting = $daemon->submit('points=100&iterations=1', sphere_ply(200));
    wait_until(sub { $daemon->status($running) eq 'running' }, 20) or die 'the job is not running';
    return ($daemon, $running, $waiting);
}

sub open_streams {
    my ($daemon, $job, $n, $address) = @_;
    my @streams;
    for my $i (1 .. $n) {
        socket my $socket, PF_INET, SOCK_STREAM, 0 or die "socket: $!";
        connect $socket, sockaddr_in($daemon->{port}, inet_aton($address)) or die "stream $i: $!";
        syswrite $socket, "GET /v1/jobs/$job/events HTTP/1.1\r\nHost: localhost\r\n\r\n";
        push @streams, $socket;
    }
    for (@streams) { sysread $_, my $bytes, 16384 or die 'a stream is refused' }
    return @streams;
}

# Latency of /livez on connections of their own.
sub probe {
    my ($daemon, $seconds) = @_;
    my ($missed, $until, @took) = (0, time + $seconds);
    while (time < $until) {
        my ($took, $status) = Sockets::timed($daemon, "GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n", 5);
        $status == 200 ? push @took, $took : $missed++;
        sleep 0.01;
    }
    return ($missed, 1e3 * Sockets::percentile(0.99, @took), scalar @took);
}

sub livez_row {
    my ($id, $daemon, $what, $most) = @_;
    my ($missed, $p99, $n) = probe($daemon, $seconds);
    Sockets::row($id, "/livez beside $what, p99 of $n, $missed missed (load " . Sockets::load() . ')', sprintf('%.1f ms', $p99), "<= $most ms, 0 missed", $p99 <= $most && !$missed);
}

# Idle ones, of a job that waits for another one, which takes a core meanwhile.
{
    my ($daemon, $running, $waiting) = begin();
    $daemon->get('/livez') for 1 .. 20;
    my ($descriptors, $before) = (Sockets::descriptors($daemon), Sockets::resident($daemon));
    my @streams = open_streams($daemon, $waiting, $streams, '127.0.0.1');
    my $each = (Sockets::resident($daemon) - $before) / 1024 / $streams;
    Sockets::row('F12', "memory of each of $streams streams (before: 47 KB)", sprintf('%.1f KB', $each), '<= 32 KB', $each <= 32);
    livez_row('F12', $daemon, "$streams idle streams", 20);
    close $_ for @streams;
    my $began = time;
    wait_until(sub { Sockets::descriptors($daemon) <= $descriptors + 2 }, 40);
    my $back = time - $began;
    Sockets::row('G15', "descriptors are back after $streams readers closed", sprintf('%.1f s', $back), '<= 30 s', $back <= 30);
    $daemon->stop('KILL');
}

# Busy ones.
{
    my $many = $long ? 4000 : 500;
    my ($daemon, $running) = begin();
    my @streams = open_streams($daemon, $running, $many, '127.0.0.1');
    livez_row('F12', $daemon, "$many streams of a job that goes on (before, 4,000: 640 ms)", 20);
    $daemon->stop('KILL');
}

# Readers that fall silent.
my $network = Sockets::network();
if (!$network) {
    print STDERR "no network of our own here: readers that fall silent are not measured\n";
} else {
    my ($beat, $many) = $long ? (15, 1000) : (3, 100);
    my ($far, $running, $waiting) = begin(listen => '0.0.0.0:0', 'no-auth' => 1, 'address-connections' => 0, heartbeat => $beat);
    my $descriptors = Sockets::descriptors($far);
    my $readers = $network->inside(sub {
        my ($out) = @_;
        my @streams = open_streams($far, $waiting, $many, $network->{ours});
        print $out "open\n";
        sleep 120;
    });
    my $in = $readers->{in};
    my $line = <$in>;
    die 'no streams from the other network' if ($line // '') ne "open\n";
    $network->silence;
    my $began = time;
    wait_until(sub { Sockets::descriptors($far) <= $descriptors + 2 }, 4 * $beat + 5);
    my $back = time - $began;
    Sockets::row('G15', "descriptors are back after $many readers fell silent, heartbeat $beat s", sprintf('%.1f s', $back), '<= ' . 2 * $beat . ' s',
        $back <= 2 * $beat);
    kill 'KILL', $readers->{pid};
    waitpid $readers->{pid}, 0;
    $far->stop('KILL');
}
