#!/usr/bin/perl
# Control bytes, broken UTF-8, quotes and long values in every field that the daemon tells again: its heads and its log hold none.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support";
use Getopt::Long;
use Vt;

my ($long, $seed) = (0, 1);
GetOptions('long' => \$long, 'seed=i' => \$seed) or exit 2;
$| = 1;
srand $seed;
my $many = $long ? 20_000 : 700;

sub row { my ($what, $figure, $wanted, $holds) = @_; print join("\t", 'G19', $what, $figure, $wanted, $holds ? 'ok' : 'short'), "\n" }

# A value of some pieces, most of them what nobody should send.
my @pieces = ("\r\n", "\n", "\0", "\e[2J", '"', '\\', '}', "\xff", "\xc0\xaf", "\xed\xa0\x80", "\xe2\x80\xae", "\x7f", '%0d%0a', '%00',
    '\\u0000', "X-Evil: 1", 'a' x 500, '../', "\t", "\xf0\x9f\x92\xa9");
sub value { return join '', map { $pieces[rand @pieces] } 1 .. 1 + rand 6 }
sub escaped { return $_[0] =~ s/([^A-Za-z0-9])/sprintf '%%%02X', ord $1/ger }

my @requests = (
    sub { "GET /" . escaped($_[0]) . " HTTP/1.1\r\n" }, sub { 'GET /v1/jobs/' . escaped($_[0]) . "/events HTTP/1.1\r\n" },
    sub { 'GET /v1/jobs?name=' . escaped($_[0]) . '&status=' . escaped($_[0]) . " HTTP/1.1\r\n" }, sub { "GET /$_[0] HTTP/1.1\r\n" },
    sub { "GET /v1/jobs HTTP/1.1\r\nX-Request-Id: $_[0]\r\n" }, sub { "GET /livez HTTP/1.1\r\ntraceparent: $_[0]\r\n" },
    sub { "GET /v1 HTTP/1.1\r\nOrigin: $_[0]\r\nX-Forwarded-For: $_[0]\r\nAccept: $_[0]\r\n" }, sub { "$_[0] /livez HTTP/1.1\r\n" },
    sub { 'POST /v1/resample?points=' . escaped($_[0]) . " HTTP/1.1\r\nIdempotency-Key: $_[0]\r\nContent-Length: 2\r\n", 'xx' },
    sub { my $json = "{\"inputs\":{\"$_[0]\":1,\"points\":\"$_[0]\"}}";
        return "POST /v1/processes/resample/execution HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: " . length($json) . "\r\n", $json },
    sub { my $form = "--b\r\nContent-Disposition: form-data; name=\"$_[0]\"; filename=\"$_[0]\"\r\n\r\n$_[0]\r\n--b--\r\n";
        return "POST /v1/resample HTTP/1.1\r\nContent-Type: multipart/form-data; boundary=b\r\nContent-Length: " . length($form) . "\r\n", $form },
);
my $daemon = Vt->start('log-level' => 'debug', 'header-timeout' => 1);
my ($raw, $planted, $answers, $server_errors) = (0, 0, 0, 0);
for my $n (1 .. $many) {
    my ($head, $body) = $requests[rand @requests]->(value());
    my $socket = $daemon->connect;
    local $SIG{PIPE} = 'IGNORE';
    $socket->syswrite("${head}Host: $daemon->{address}\r\nConnection: close\r\n\r\n" . ($body // ''));
    shutdown $socket, 1;
    my $answer = head_of(Vt::read_all($socket)) // '';
    $answers++ if length $answer;
    $raw++ if $answer =~ /[^\r\n\x20-\x7e]/;
    $planted++ if $answer =~ /^X-Evil/mi;
    $server_errors++ if $answer =~ m{\AHTTP/1\.1 5(?!05)};
}
row("$many hostile requests: heads of answers with a raw byte", $raw, 0, $raw == 0);
row("fields of theirs in these heads, of $answers answers", $planted, 0, $planted == 0);
row('answers of 5xx', $server_errors, 0, $server_errors == 0);
row('the daemon answers after them', $daemon->get('/livez')->{status}, 200, $daemon->get('/livez')->{status} == 200);
$daemon->stop;
my ($bad, $longest, $lines) = (0, 0, 0);
for my $line (split /\n/, $daemon->log_text) {
    $lines++;
    $bad++ unless $line !~ /[\x00-\x1f\x7f]/ && eval { ref JSON::PP::decode_json($line) eq 'HASH' };
    $longest = length $line if length $line > $longest;
}
row("of $lines lines of the log, none of JSON", $bad, 0, $bad == 0);
row('longest of them', "$longest bytes", '2048 bytes at most', $longest <= 2048);
