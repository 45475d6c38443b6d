#!/usr/bin/perl
# Mutated requests, 1,500 here and 1,000,000 in the long form: bytes flipped, cut, doubled and put in, several in a row on a connection.
# The daemon stays up, answers none with a 5xx, and has as many descriptors and as much memory afterwards. Every answer of its own that
# is an error is a problem with a type.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use JSON::PP ();
use Time::HiRes qw(sleep time);
use Sockets;
use Vt;

my ($long, $seed, $count) = Sockets::options();
$count //= $long ? 1_000_000 : 1500;
my $seconds = $long ? $ENV{TORTURE_SECONDS} // 1e9 : 1e9;
my $daemon = Vt->start('header-timeout' => 2, 'body-idle' => 2, queue => 100000, 'keep-inputs' => 0, 'result-ttl' => 5);
my $cloud = sphere_ply(20);
my $id = $daemon->submit('points=5&iterations=1', $cloud);
$daemon->finish($id);
my $host = "Host: localhost\r\n";
my $json = '{"inputs":{"points":5,"iterations":1}}';
my @seeds = (
    "GET /livez HTTP/1.1\r\n$host\r\n", "GET /v1/jobs?limit=2&status=successful HTTP/1.1\r\n$host\r\n", "GET /v1/jobs/$id HTTP/1.1\r\n${host}If-None-Match: \"x\"\r\n\r\n",
    "HEAD /v1/jobs/$id/results/cloud HTTP/1.1\r\n$host\r\n", "GET /v1/jobs/$id/results/cloud HTTP/1.1\r\n${host}Range: bytes=0-99\r\n\r\n",
    "GET /v1/jobs/$id/events HTTP/1.1\r\n${host}Last-Event-ID: 1.1\r\n\r\n", "GET /v1/jobs/$id/trace HTTP/1.1\r\n${host}Accept: text/csv\r\n\r\n",
    "DELETE /v1/jobs/00000000-0000-7000-8000-000000000000 HTTP/1.1\r\n$host\r\n", "OPTIONS /v1/resample HTTP/1.1\r\n${host}Origin: http://x\r\n\r\n",
    "POST /v1/resample?points=5&iterations=1&polish=0 HTTP/1.1\r\n${host}Content-Length: " . length($cloud) . "\r\n\r\n$cloud",
    "POST /v1/resample?points=5&iterations=1 HTTP/1.1\r\n${host}Prefer: respond-async\r\nTransfer-Encoding: chunked\r\n\r\n"
        . sprintf("%x\r\n%s\r\n0\r\n\r\n", length $cloud, $cloud),
    "POST /v1/processes/resample/execution HTTP/1.1\r\n${host}Content-Type: application/json\r\nContent-Length: " . length($json) . "\r\n\r\n$json",
    "GET /v1/processes/resample HTTP/1.1\r\n${host}Accept: application/json\r\nX-Request-Id: abc\r\n\r\n", "GET /openapi.yaml HTTP/1.0\r\n\r\n",
);
my @bits = ("\r\n", "\r", "\n", "\0", ' ', "\t", ':', '%00', '%2f', '..', '?', '&', '=', '#', "\xff", 'Content-Length: 1' . "\r\n", "Transfer-Encoding: chunked\r\n",
    $host, 'HTTP/1.1', '0', '-1', '9' x 25, 'x' x 3000, '[::1]', "\r\n\r\n", 'POST ', ';', '"', '{', 'Expect: 100-continue' . "\r\n");

sub mutant {
    my ($bytes) = @_;
    for (0 .. int rand 3) {
        my $size = length $bytes;
        my $at = int rand(rand() < 0.7 && $size > 120 ? 120 : $size + 1);
        my $much = int rand(rand() < 0.8 ? 6 : $size - $at + 1);
        my $how = int rand 5;
        if ($how == 0) { substr($bytes, $at, 1) ^= chr(1 << int rand 8) if $at < $size }
        elsif ($how == 1) { substr($bytes, $at, $much) = '' }
        elsif ($how == 2) { substr($bytes, $at, 0) = substr $bytes, $at, $much }
        else { substr($bytes, $at, $how == 3 ? 0 : $much) = $bits[rand @bits] }
    }
    return $bytes;
}

# Sends some requests, closes its side, and waits as long as something comes; what came.
sub talk {
    my ($bytes) = @_;
    my $socket = Sockets::connect_to($daemon) // return undef;
    my $all = '';
    syswrite $socket, $bytes;
    shutdown $socket, 1;
    while (IO::Select->new($socket)->can_read(length $all ? 0.02 : 0.1)) { last unless sysread $socket, $all, 65536, length $all }
    return $all;
}

local $SIG{PIPE} = 'IGNORE';
my ($pid, $fives, $unnamed, $errors, $gone) = ($daemon->{pid}, 0, 0, 0, 0);
my ($descriptors, $memory, %opened);
my ($at, $began) = (0, time);
while ($at < $count && (time - $began < $seconds || !defined $descriptors)) {
    my @requests = map { rand() < 0.9 ? mutant($seeds[rand @seeds]) : $seeds[rand @seeds] } 1 .. 1 + int rand 3;
    truncate $daemon->{log}, 0 if int(($at + @requests) / 10000) > int($at / 10000);
    $at += @requests;
    my $raw = talk(join '', @requests);
    if (!defined $raw) { $gone++; last if !kill 0, $pid; next }
    my $last = '';
    while ($raw =~ m{HTTP/1\.1 (\d)(\d\d) [^\r]*\r\n(.*?)\r\n\r\n((?:(?!HTTP/1\.1 )[^\r])*)}sg) {
        my ($class, $rest, $head, $body) = ($1, $2, $3, $4);
        # 505 is what the library says of a version that it does not speak, 503 what a full queue would.
        if ($class == 5 && $rest !~ /^0[35]$/) { $fives++; print STDERR "$class$rest $head\n" }
        next unless $class == 4 && $head =~ m{application/problem\+json} && length $body; # HEAD has none
        $errors++;
        next if $body =~ /"type":"[^"]+"/;
        $unnamed++;
        print STDERR "$class$rest $head\n$body\n";
    }
    next if defined $descriptors || $at < $count / 2 && time - $began < $seconds / 2;
    sleep 3; # until the last ones are cut, see header-timeout
    ($descriptors, $memory) = (Sockets::descriptors($daemon), Sockets::resident($daemon));
    %opened = map { $_ => 1 } Sockets::opened($daemon);
}
if (!wait_until(sub { Sockets::descriptors($daemon) <= $descriptors + 2 }, 20)) {
    print STDERR "open and not half way: $_\n" for grep { !$opened{$_} } Sockets::opened($daemon);
}
my $alive = eval { $daemon->get('/livez')->{status} } // 0;
my $left = Sockets::descriptors($daemon) - $descriptors;
my $grown = 100 * (Sockets::resident($daemon) / $memory - 1);
Sockets::row('G7', "restarts and refused connections in $at mutated requests, seed $seed", $gone + ($alive == 200 ? 0 : 1), 0, !$gone && $alive == 200);
Sockets::row('G7', "answers with a 5xx in $at mutated requests", $fives, 0, !$fives);
Sockets::row('G7', "problems without a type, of $errors", $unnamed, 0, $errors && !$unnamed);
Sockets::row('G7', 'descriptors more than half way', $left, '<= 2', $left <= 2);
Sockets::row('G7', 'memory more than half way', sprintf('%.1f %%', $grown), '<= 5 %', $grown <= 5);
my $status = $daemon->stop;
Sockets::row('G7', 'it ends with', $status, 0, $status eq '0');
