#!/usr/bin/perl
# Requests whose framing two servers may read differently: none may be accepted. Behind each stands a second request, which must not be
# answered. Then sound pairs on kept connections, which must stay apart.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Sockets;
use Vt;

my ($long, $seed) = Sockets::options();
my $daemon = Vt->start('header-timeout' => 1, 'body-idle' => 1);
my $host = "Host: localhost\r\n";
my $post = "POST /v1/resample?points=1 HTTP/1.1\r\n$host";
my $get = "GET /livez HTTP/1.1\r\n";
my $second = "GET /smuggled HTTP/1.1\r\n$host\r\n";
my @cases = (
    ['CL and TE', "${post}Content-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"],
    ['TE and CL', "${post}Transfer-Encoding: chunked\r\nContent-Length: 4\r\n\r\n0\r\n\r\n"],
    ['two CL', "${post}Content-Length: 4\r\nContent-Length: 5\r\n\r\n12345"], ['two equal CL', "${post}Content-Length: 4\r\nContent-Length: 4\r\n\r\n1234"],
    ['a list of CL', "${post}Content-Length: 4, 4\r\n\r\n1234"], ['CL with a sign', "${post}Content-Length: +4\r\n\r\n1234"],
    ['negative CL', "${post}Content-Length: -4\r\n\r\n1234"], ['hexadecimal CL', "${post}Content-Length: 0x4\r\n\r\n1234"],
    ['CL of 30 digits', "${post}Content-Length: " . '9' x 30 . "\r\n\r\n"], ['empty CL', "${post}Content-Length:\r\n\r\n1234"],
    ['CL with a blank', "${post}Content-Length : 4\r\n\r\n1234"], ['two Hosts', "$get${host}Host: other\r\n\r\n"], ['two equal Hosts', "$get$host$host\r\n"],
    ['no Host', "$get\r\n"], ['TE xchunked', "${post}Transfer-Encoding: xchunked\r\n\r\n0\r\n\r\n"],
    ['TE identity', "${post}Transfer-Encoding: identity\r\n\r\n"], ['two TE', "${post}Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"],
    ['TE list', "${post}Transfer-Encoding: gzip, chunked\r\n\r\n0\r\n\r\n"], ['TE chunked, chunked', "${post}Transfer-Encoding: chunked, chunked\r\n\r\n0\r\n\r\n"],
    ['TE with a blank', "${post}Transfer-Encoding : chunked\r\n\r\n0\r\n\r\n"], ['TE with a tab', "${post}Transfer-Encoding:\tx\r\n\r\n0\r\n\r\n"],
    ['TE in HTTP/1.0', "POST /v1/resample?points=1 HTTP/1.0\r\n${host}Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"],
    ['a blank in a name', "$get${host}X T: v\r\n\r\n"], ['a blank before the colon', "$get${host}X-T : v\r\n\r\n"],
    ['NUL in a name', "$get${host}X\0T: v\r\n\r\n"], ['CR in a name', "$get${host}X\rT: v\r\n\r\n"], ['\x01 in a name', "$get${host}X\x01T: v\r\n\r\n"],
    ['NUL in a value', "$get${host}X: a\0b\r\nY: v\r\n\r\n"], ['CR in a value', "$get${host}X: a\rb\r\n\r\n"], ['ESC in a value', "$get${host}X: a\x1bb\r\n\r\n"],
    ['a folded value', "$get${host}X: a\r\n b\r\nY: v\r\n\r\n"], ['a bare LF', "GET /livez HTTP/1.1\n$host\r\n"], ['no colon', "$get${host}Xv\r\n\r\n"],
    ['a blank before the first field', "$get X: v\r\n$host\r\n"], ['HTTP/1.2', "GET /livez HTTP/1.2\r\n$host\r\n"], ['HTTP/2.0', "GET /livez HTTP/2.0\r\n$host\r\n"],
    ['no version', "GET /livez\r\n\r\n"], ['NUL in the target', "GET /livez\0x HTTP/1.1\r\n$host\r\n"],
    (map { ["$_ in the path", "GET /v1/jobs$_/x HTTP/1.1\r\n$host\r\n"] } qw(%00 %2f %2F %5c %2e %2E)), ['a blank in the target', "GET /livez x HTTP/1.1\r\n$host\r\n"],
    ['an absolute target', "GET http://evil/livez HTTP/1.1\r\n$host\r\n"],
);
my @accepted;
for my $case (@cases) {
    my $raw = $daemon->raw("$case->[1]$second");
    push @accepted, $case->[0] if $raw !~ m{\A(?:HTTP/1\.1 (?:4\d\d|505) .*)?\z}s || $raw =~ /no-such-resource/;
}
print STDERR "accepted: @accepted\n" if @accepted;
Sockets::row('G13', 'odd framings accepted, of ' . @cases, scalar(@accepted), 0, !@accepted);
my $followed = grep { ($_->{path} // '') eq '/smuggled' } $daemon->log_lines;
Sockets::row('G13', 'second requests behind them that were answered', $followed, 0, !$followed);

# Pairs: a chunked or counted body, then a request that names itself.
my ($pairs, $wrong) = ($long ? 1000 : 200, 0);
for my $i (1 .. $pairs) {
    my $body = 'x' x int(rand() * 300);
    my $first = rand() < 0.5
        ? "${post}X-Request-Id: a$i\r\nContent-Length: " . length($body) . "\r\n\r\n$body"
        : "${post}X-Request-Id: a$i\r\nTransfer-Encoding: chunked\r\n\r\n" . join('', map { sprintf "%x\r\n%s\r\n", length $_, $_ } grep { length } unpack '(A70)*', $body) . "0\r\n\r\n";
    my $raw = $daemon->raw("${first}GET /version HTTP/1.1\r\n${host}X-Request-Id: b$i\r\nConnection: close\r\n\r\n");
    my @ids = $raw =~ /^X-Request-Id: (\S+)\r$/mg;
    $wrong++ if "@ids" ne "a$i b$i" || $raw !~ /"version"/;
}
Sockets::row('G13', "pairs of requests on one connection that were not kept apart, of $pairs", $wrong, 0, !$wrong);
$daemon->stop;
