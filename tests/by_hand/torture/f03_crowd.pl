#!/usr/bin/perl
# Everybody who wants to starve the others, together: silent connections, heads that drip, bodies that drip, readers that read a
# byte at a time; whoever is cut comes back, 150 a second. Meanwhile /livez is asked and jobs are submitted: none may be missed.
use strict;
use warnings;
BEGIN { @main::ARGV_WAS = @ARGV }
use Fcntl qw(F_GETFL F_SETFL O_NONBLOCK);
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Time::HiRes qw(sleep time);
use Sockets;
use Vt;

my ($long, $seed) = Sockets::options();
my $files = Sockets::files(7000);
my %want = $long ? (silent => 5000, head => 500, body => 300, reader => 300) : (silent => 1200, head => 100, body => 60, reader => 60);
$want{silent} = $files - 1400 if $want{silent} > $files - 1400;
my $seconds = $long ? 60 : 4;
my $host = "Host: localhost\r\n";
my $daemon = Vt->start(queue => 100000, $long ? () : ('header-timeout' => 3, 'body-idle' => 4));
my $key = $ENV{TORTURE_KEY} ? "Authorization: Bearer $ENV{TORTURE_KEY}\r\n" : '';
my $big = Sockets::large_result($daemon);
my %begin = (
    silent => '',
    head => "GET /livez HTTP/1.1\r\nX-",
    body => "POST /v1/resample?points=9 HTTP/1.1\r\n${host}Content-Length: 100000\r\n\r\nply",
    reader => "GET /v1/jobs/$big/results/cloud HTTP/1.1\r\n$host\r\n",
);

# The good ones, in processes of their own.
sub good {
    my ($name, $bytes, $status) = @_;
    return Sockets::beside(sub {
        my ($out) = @_;
        my $until = time + $seconds;
        while (time < $until) {
            my ($took, $got) = Sockets::timed($daemon, $bytes, 5);
            printf $out "%s %.6f\n", $got == $status ? 'ok' : "missed:$got", $took;
            sleep 0.03;
        }
    });
}

local $SIG{PIPE} = 'IGNORE';
my (%sockets, %kind);
sub enter {
    my ($kind) = @_;
    my $socket = Sockets::connect_to($daemon, $kind eq 'reader' ? 4096 : 0) // return;
    fcntl $socket, F_SETFL, fcntl($socket, F_GETFL, 0) | O_NONBLOCK;
    syswrite $socket, $begin{$kind} if length $begin{$kind};
    $sockets{ fileno $socket } = $socket;
    $kind{ fileno $socket } = $kind;
}
for my $kind (sort keys %want) { enter($kind) for 1 .. $want{$kind} }
my $close = "Connection: close\r\n";
my $cloud = sphere_ply(100);
my $livez = good('livez', "GET /livez HTTP/1.1\r\n$host$close\r\n", 200);
my $submit = good('submit', "POST /v1/resample?points=20&iterations=1&polish=0 HTTP/1.1\r\n$host$close${key}Prefer: respond-async\r\n"
    . 'Content-Length: ' . length($cloud) . "\r\n\r\n$cloud", 201);
my ($until, $again) = (time + $seconds + 0.5, 0);
while (time < $until) {
    my $turn = time;
    for my $fd (keys %sockets) {
        my ($socket, $kind) = ($sockets{$fd}, $kind{$fd});
        my $alive = 1;
        if ($kind eq 'head' || $kind eq 'body') {
            $alive = defined syswrite $socket, 'x';
        } else {
            my $got = sysread $socket, my $byte, 1;
            $alive = 0 if defined $got ? $got == 0 : !$!{EAGAIN};
        }
        next if $alive;
        delete $sockets{$fd};
        close $socket;
        enter($kind);
        last if ++$again % 300 == 0; # so many a turn
    }
    my $left = $turn + 2 - time;
    sleep $left if $left > 0;
}
my $who = "$want{silent} silent, $want{head} heads, $want{body} bodies that drip, $want{reader} slow readers; $again came back; load " . Sockets::load();
for my $case (['/livez', $livez], ['submit', $submit]) {
    my ($name, $process) = @$case;
    my @lines = Sockets::take_lines($process);
    my @missed = grep { /^missed/ } @lines;
    my $p99 = 1e3 * Sockets::percentile(0.99, map { (split)[1] } @lines);
    Sockets::row('CROWD', "$name beside $who: missed of " . scalar @lines, scalar(@missed), 0, @lines && !@missed);
    Sockets::row('CROWD', "$name beside them, p99", sprintf('%.1f ms', $p99), '<= 100 ms', @lines && $p99 <= 100);
    print STDERR "$missed[0]\n" if @missed;
}
$daemon->stop('KILL');
