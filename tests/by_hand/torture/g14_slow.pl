#!/usr/bin/perl
# Slow clients of three kinds beside each other: heads and bodies that come a byte at a time, and readers that take one a second.
# Each is to be cut at its deadline, while good clients are served. The short form has shorter deadlines and fewer clients.
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
my $files = Sockets::files(4000);
my $each = $long ? 1000 : 100;
my ($head, $idle, $pause) = $long ? (10, 30, 2) : (2, 3, 0.5);
my $host = "Host: localhost\r\n";
my $daemon = Vt->start(connections => 4000, 'header-timeout' => $head, 'body-idle' => $idle);
my $big = Sockets::large_result($daemon);
my %kinds = (
    head => ["GET /livez HTTP/1.1\r\nX-", $head + 1],
    body => ["POST /v1/resample?points=9 HTTP/1.1\r\n${host}Content-Length: 100000\r\n\r\nply", $idle + 1],
    reader => ["GET /v1/jobs/$big/results/cloud HTTP/1.1\r\n$host\r\n", 2 * $idle],
);
my $seconds = 2 * $idle + 2;
my $good = Sockets::beside(sub {
    my ($out) = @_;
    my $until = time + $seconds - 1;
    while (time < $until) {
        my ($took, $status) = Sockets::timed($daemon, "GET /v1/jobs HTTP/1.1\r\n${host}Connection: close\r\n\r\n", 5);
        print $out "$status $took\n";
        sleep 0.02;
    }
});

local $SIG{PIPE} = 'IGNORE';
my %alive;
for my $kind (sort keys %kinds) {
    for my $i (1 .. $each) {
        my $socket = Sockets::connect_to($daemon, $kind eq 'reader' ? 4096 : 0) // die "connect: $!";
        fcntl $socket, F_SETFL, fcntl($socket, F_GETFL, 0) | O_NONBLOCK;
        syswrite $socket, $kinds{$kind}[0];
        $alive{"$kind $i"} = [$socket, time];
    }
}
my %longest = map { $_ => 0 } keys %kinds;
my %cut = map { $_ => 0 } keys %kinds;
my $began = time;
while (%alive && time - $began < $seconds) {
    for my $name (keys %alive) {
        my ($socket, $since) = @{ $alive{$name} };
        my ($kind) = split ' ', $name;
        my $got = sysread $socket, my $bytes, $kind eq 'reader' ? 1 : 4096;
        my $gone = defined $got ? $got == 0 || $kind ne 'reader' : !$!{EAGAIN};
        $gone = 1 if !$gone && $kind ne 'reader' && !defined syswrite($socket, 'x') && !$!{EAGAIN};
        next unless $gone;
        my $age = time - $since;
        $longest{$kind} = $age if $age > $longest{$kind};
        $cut{$kind}++;
        delete $alive{$name};
    }
    sleep $pause;
}
# A reader that was cut still has what was on its way: its request is over when the log says so.
my %reading = map { $_->{request_id} => $_->{dur_s} } grep { ($_->{path} // '') =~ m{/results/cloud\z} } $daemon->log_lines;
$cut{reader} = keys %reading;
for (values %reading) { $longest{reader} = $_ if $_ > $longest{reader} }
my %words = (head => 'heads that come a byte at a time', body => 'bodies that come a byte at a time', reader => 'readers of a byte at a time');
for my $kind (qw(head body reader)) {
    my $most = $kinds{$kind}[1] + $pause;
    Sockets::row('G14', "$each $words{$kind}: " . ($each - $cut{$kind}) . ' not cut; the last after', sprintf('%.1f s', $longest{$kind}), "<= $most s",
        $cut{$kind} == $each && $longest{$kind} <= $most);
}
my @lines = Sockets::take_lines($good);
my @missed = grep { !/^200/ } @lines;
my $p99 = 1e3 * Sockets::percentile(0.99, map { (split)[1] } @lines);
Sockets::row('G14', 'good clients beside them: missed of ' . @lines, scalar(@missed), 0, @lines && !@missed);
Sockets::row('G14', 'good clients beside them, p99 (load ' . Sockets::load() . ')', sprintf('%.1f ms', $p99), '<= 50 ms', @lines && $p99 <= 50);
$daemon->stop('KILL');
