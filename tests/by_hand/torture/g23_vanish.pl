#!/usr/bin/perl
# Clients that vanish in the middle of an upload, a stream and a download: with a reset, and without a word. Nothing of them may be
# left: no temporary file after 60 s, no descriptor, no memory; the job that was watched or read goes on.
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
Sockets::files(3000);
my $each = $long ? 1000 : 50;
my $beat = $long ? 15 : 2;
my $network = Sockets::network();
my $daemon = Vt->start(connections => 3000, streams => 1500, jobs => 1, threads => 1, heartbeat => $beat, 'body-idle' => $long ? 30 : 2,
    $network ? (listen => '0.0.0.0:0', 'no-auth' => 1, 'address-connections' => 0) : ());
my $big = Sockets::large_result($daemon);
my $running = $daemon->submit('points=5000&iterations=10000&polish=0', sphere_ply(20000));
wait_until(sub { $daemon->status($running) eq 'running' }, 20) or die 'no job runs';
my %begin = (
    upload => "POST /v1/resample?points=9 HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n\r\nply\n" . 'x' x 2000,
    stream => "GET /v1/jobs/$running/events HTTP/1.1\r\nHost: localhost\r\n\r\n",
    download => "GET /v1/jobs/$big/results/cloud HTTP/1.1\r\nHost: localhost\r\n\r\n",
);
sub files { return scalar grep { -f } glob "$daemon->{dir}/data/blobs/* $daemon->{dir}/data/blobs/*/*" }

sub enter {
    my ($address) = @_;
    my @sockets;
    for my $kind (sort keys %begin) {
        for (1 .. $each) {
            socket my $socket, PF_INET, SOCK_STREAM, 0 or die "socket: $!";
            setsockopt $socket, SOL_SOCKET, SO_RCVBUF, 4096 if $kind eq 'download';
            connect $socket, sockaddr_in($daemon->{port}, inet_aton($address)) or die "$kind: $!";
            syswrite $socket, $begin{$kind};
            push @sockets, $socket;
        }
    }
    sleep 0.5;
    return @sockets;
}

sub settle {
    my ($how, $most, $files, $descriptors) = @_;
    my $began = time;
    wait_until(sub { files() <= $files && Sockets::descriptors($daemon) <= $descriptors + 2 }, 70);
    my $took = time - $began;
    Sockets::row('G23', "$each uploads, streams, downloads each vanish $how: files and descriptors are back", sprintf('%.1f s', $took), "<= $most s",
        $took <= $most);
    Sockets::row('G23', "temporary files left of those who vanished $how", files() - $files, 0, files() <= $files);
}

$daemon->get('/livez');
my ($files, $descriptors) = (files(), Sockets::descriptors($daemon));
my $memory;
for my $round (1 .. 2) {
    my @sockets = enter('127.0.0.1');
    setsockopt $_, SOL_SOCKET, SO_LINGER, pack('ii', 1, 0) for @sockets; # closing sends a reset
    close $_ for @sockets;
    $round == 2 ? settle('with a reset', 60, $files, $descriptors) : wait_until(sub { Sockets::descriptors($daemon) <= $descriptors + 2 }, 70);
    $memory //= Sockets::resident($daemon);
}
my $grown = (Sockets::resident($daemon) - $memory) / 1048576;
Sockets::row('G23', 'memory grown from the first such round to the second', sprintf('%.1f MB', $grown), '<= 2 MB', $grown <= 2);
if ($network) {
    my $there = $network->inside(sub { my ($out) = @_; my @sockets = enter($network->{ours}); print $out "in\n"; sleep 300 });
    my $in = $there->{in};
    defined(my $line = <$in>) or die 'nobody came from the other network';
    $network->silence;
    settle('without a word', 60, $files, $descriptors);
    kill 'KILL', $there->{pid};
    waitpid $there->{pid}, 0;
} else {
    print STDERR "no network of our own here: those who vanish without a word are not measured\n";
}
Sockets::row('G23', 'the job that they watched', $daemon->status($running), 'running', $daemon->status($running) eq 'running');
$daemon->stop('KILL');
