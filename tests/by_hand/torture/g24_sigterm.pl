#!/usr/bin/perl
# SIGTERM under load: 40 clients submit, ask and read, each request on a connection of its own, while the daemon is told to
# end. Whoever was let in gets an answer; whatever was accepted is there after the next start. Then SIGTERM with clients that are
# slow in every way, which must not hold the daemon beyond its drain.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use IO::Select;
use POSIX ();
use Socket;
use Time::HiRes qw(sleep time);
use Sockets;
use Vt;

my ($long, $seed) = Sockets::options();
my $rounds = $long ? 30 : 3;
my $cloud = sphere_ply(300);
my ($resets, $lost, $asked, $accepted, $slowest_ready, $longest) = (0, 0, 0, 0, 0, 0);

# One request on a connection of its own: the answer, '' when it was refused before it was accepted, undef when it was cut.
sub ask {
    my ($daemon, $bytes) = @_;
    socket my $socket, PF_INET, SOCK_STREAM, 0 or die "socket: $!";
    connect $socket, sockaddr_in($daemon->{port}, inet_aton('127.0.0.1')) or return '';
    my $all = '';
    for (my $at = 0; $at < length $bytes;) { $at += syswrite($socket, substr $bytes, $at) // return undef }
    while (1) {
        my $got = sysread $socket, $all, 65536, length $all;
        return undef unless defined $got;
        last unless $got;
    }
    return $all =~ m{\AHTTP/1\.1 \d} ? $all : undef;
}

sub client {
    my ($daemon, $out, $i) = @_;
    my $post = "POST /v1/resample?points=50&iterations=3&polish=0 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
        . "Prefer: respond-async\r\nContent-Length: " . length($cloud) . "\r\n\r\n$cloud";
    my $get = "GET /v1/jobs?limit=5 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    for my $turn (1 .. 100000) {
        my $answer = ask($daemon, ($turn + $i) % 2 ? $post : $get);
        last if defined $answer && $answer eq '';
        print $out defined $answer ? $answer =~ m{\AHTTP/1\.1 201.*"jobID":"([^"]+)"}s ? "job $1\n" : "ok\n" : "cut\n";
    }
    close $out;
}

local $SIG{PIPE} = 'IGNORE';
for my $round (1 .. $rounds) {
    my $daemon = Vt->start('drain-timeout' => 5, jobs => 2, queue => 100000);
    my $dir = $daemon->{dir};
    pipe my $in, my $out or die "pipe: $!";
    $out->autoflush(1);
    my @clients;
    for my $i (1 .. 40) {
        my $pid = fork // die "fork: $!";
        if (!$pid) { close $in; eval { client($daemon, $out, $i) }; POSIX::_exit(0) }
        push @clients, $pid;
    }
    close $out;
    sleep 0.4 + rand 0.4;
    my $began = time;
    kill 'TERM', $daemon->{pid};
    while ((my $sent = time - $began) < 5) {
        my $answer = ask($daemon, "GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n") // '';
        last if $answer !~ m{\AHTTP/1\.1 200};
        $slowest_ready = $sent if $sent > $slowest_ready;
    }
    my $status = $daemon->stop('CONT');
    my $took = time - $began;
    $longest = $took if $took > $longest;
    die "the daemon ended with $status" if $status ne '0';
    my @said = <$in>;
    waitpid $_, 0 for @clients;
    $asked += @said;
    $resets += grep { /^cut/ } @said;
    my @jobs = map { /^job (\S+)/ ? $1 : () } @said;
    $accepted += @jobs;
    my $again = Vt->start(dir => $dir, jobs => 4, queue => 100000);
    $lost += grep { $again->get("/v1/jobs/$_")->{status} != 200 } @jobs;
    $again->stop;
}
Sockets::row('G24', "$rounds SIGTERM under 40 clients: requests of $asked cut without an answer", $resets, 0, $resets == 0);
Sockets::row('G24', "accepted jobs of $accepted that are not there after the next start", $lost, 0, $lost == 0);
Sockets::row('G24', 'last /readyz that was sent after SIGTERM and answered 200', sprintf('%.0f ms', 1e3 * $slowest_ready), '<= 100 ms', $slowest_ready <= 0.1);
Sockets::row('G24', 'the daemon ends with 0, drain-timeout 5 s', sprintf('%.1f s', $longest), '<= 10 s', $longest <= 10);

# Slow in every way.
{
    my $drain = 2;
    my $daemon = Vt->start('drain-timeout' => $drain, 'body-idle' => 60, 'reply-rate' => 0);
    my $id = $daemon->submit('points=200000&iterations=1&polish=0', sphere_ply(20000));
    $daemon->finish($id);
    my @slow = map { $daemon->connect } 1 .. 40;
    my @say = ("GET /livez HTTP/1.1\r\nHo", "POST /v1/resample?points=9 HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000\r\n\r\nply",
        "GET /v1/jobs/$id/results/cloud HTTP/1.1\r\nHost: localhost\r\n\r\n", "GET /v1/jobs/$id/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    $slow[$_]->syswrite($say[$_ % 4]) for 0 .. $#slow;
    sleep 0.3;
    my $began = time;
    my $status = $daemon->stop;
    my $took = time - $began;
    Sockets::row('F13', "SIGTERM with 40 slow clients ends with $status, drain-timeout $drain s (before: + 10 s)", sprintf('%.1f s', $took), '<= ' . ($drain + 5) . ' s', $status eq '0' && $took <= $drain + 5);
}
