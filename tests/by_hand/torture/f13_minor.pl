#!/usr/bin/perl
# Small holes: Hosts that are none, NUL in the target, the library's errors with their head twice, and a device without an end on the
# command line.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Time::HiRes qw(time);
use Sockets;
use Vt;

Sockets::options();
my $binary = $ENV{VORONOID} // 'build/release/voronoid';
my $daemon = Vt->start;

sub status { return $_[0] =~ m{\AHTTP/1\.1 (\d+)} ? $1 : 0 }

my @hosts = ('[::1]evil.example', 'localhost:evil.com', 'localhost:', 'localhost:0', 'localhost:65536', '[::1]:80x', '[::1', 'localhost.evil.example',
    '127.0.0.1.evil.example', 'localhost@evil.example', 'evil.example', 'localhost:80:80');
my $passed = grep {
    my $raw = $daemon->raw("GET /v1/ HTTP/1.1\r\nHost: $_\r\nConnection: close\r\n\r\n");
    status($raw) !~ /^4/ || $raw =~ /evil[^"]*\/v1/;
} @hosts;
Sockets::row('F13', 'Hosts that are none of ours, of ' . @hosts . ': answered or reflected in a link', $passed, 0, $passed == 0);

my @targets = ("/livez\0", "/livez\0x", "/v1/jobs?limit=1\0&x", "\0/livez", "/v1/\0/jobs");
$passed = grep { status($daemon->raw("GET $_ HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")) !~ /^4/ } @targets;
Sockets::row('F13', 'targets with NUL, of ' . @targets . ': answered', $passed, 0, $passed == 0);

my %early = ('no Host' => "GET /livez HTTP/1.1\r\n\r\n",
    'a head of 60,000 bytes' => "GET /livez HTTP/1.1\r\nHost: localhost\r\nX: " . 'v' x 60000 . "\r\n\r\n",
    'a Content-Length that is none' => "POST /v1/resample HTTP/1.1\r\nHost: localhost\r\nContent-Length: x\r\n\r\n");
for my $name (sort keys %early) {
    my $raw = $daemon->raw($early{$name});
    my $heads = () = $raw =~ m{^HTTP/1\.1 }mg;
    Sockets::row('F13', "$name is refused with so many heads" . ($heads > 1 ? ' (by the library, before it calls us: a look at the bytes would need a parser of our own before its, on every connection)' : ''), $heads, 1, $heads == 1);
}
$daemon->stop;

for my $how ("$binary resample /dev/zero -n 10 -o /dev/null", "$binary resample - -n 10 -o /dev/null < /dev/zero", "yes | $binary inspect -") {
    my $began = time;
    my $said = `{ $how; } 2>&1`;
    my $took = time - $began;
    Sockets::row('F13', "$how: refused by its first bytes (before: 8 GB)" =~ s/\Q$binary\E/voronoid/r, sprintf('%.2f s', $took), '<= 1 s',
        $took <= 1 && $said =~ /the input begins with/);
}
