#!/usr/bin/perl
# Bytes that end a line or hide one, in every field that comes back in an answer or in the log: path, query, headers, request id, name of a
# job, file name of a form, members of JSON. None may come back raw, and every line of the log must be JSON.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support", $FindBin::Bin;
use JSON::PP ();
use Sockets;
use Vt;

my ($long, $seed) = Sockets::options();
my $daemon = Vt->start;
my $cloud = sphere_ply(50);
my %evil = (CR => "a\rInjected: 1", LF => "a\nInjected: 1", CRLF => "a\r\nInjected: 1", NUL => "a\0b", ESC => "a\e[31mb", 'invalid UTF-8' => "a\xff\xc0\xafb",
    'C1' => "a\xc2\x85b", quotes => 'a"b\\c', long => 'v' x 20000);
sub escaped { return $_[0] =~ s/([^A-Za-z0-9])/sprintf '%%%02X', ord $1/ger }
my ($asked, $raw_bytes) = (0, 0);
my %count;

sub send_one {
    my ($field, $evil, $bytes) = @_;
    my $raw = $daemon->raw($bytes, 5);
    my $head = head_of($raw) // '';
    my $text = $head =~ /^Content-Type: application\/(?:problem\+)?json/m ? $raw : $head;
    $asked++;
    $count{$field}++;
    return if $head !~ /^Injected|[\x80-\xff]/m && $text !~ /[\0\e\x7f\xff]/;
    $raw_bytes++;
    print STDERR "$field, $evil: ", substr($raw, 0, 300), "\n";
}
for my $name (sort keys %evil) {
    my ($value, $quoted) = ($evil{$name}, escaped($evil{$name}));
    my $json = $value =~ s/(["\\])/\\$1/gr;
    my $close = "Host: localhost\r\nConnection: close\r\n";
    send_one('path', $name, "GET /v1/jobs/$value HTTP/1.1\r\n$close\r\n");
    send_one('path, escaped', $name, "GET /v1/jobs/$quoted HTTP/1.1\r\n$close\r\n");
    send_one('query', $name, "GET /v1/jobs?limit=$quoted HTTP/1.1\r\n$close\r\n");
    send_one('name of a query', $name, "GET /v1/jobs?$quoted=1 HTTP/1.1\r\n$close\r\n");
    send_one("header $_", $name, "GET /v1/jobs HTTP/1.1\r\n${close}$_: $value\r\n\r\n") for qw(X-Request-Id Accept Origin Prefer If-None-Match Last-Event-ID Forwarded X-Forwarded-Host Range);
    send_one('Host', $name, "GET /v1/jobs HTTP/1.1\r\nHost: $value\r\nConnection: close\r\n\r\n");
    send_one('method', $name, "$value /v1/jobs HTTP/1.1\r\n$close\r\n");
    my $post = sub { my ($path, $type, $body) = @_; return "POST $path HTTP/1.1\r\n${close}Content-Type: $type\r\nContent-Length: " . length($body) . "\r\n\r\n$body" };
    send_one('name of a job', $name, $post->("/v1/resample?points=9&iterations=1&name=$quoted", 'application/ply', $cloud));
    send_one('Idempotency-Key', $name, "POST /v1/resample?points=9 HTTP/1.1\r\n${close}Idempotency-Key: $value\r\nContent-Length: " . length($cloud) . "\r\n\r\n$cloud");
    send_one('Content-Type', $name, $post->('/v1/resample?points=9', $value, $cloud));
    send_one('JSON member', $name, $post->('/v1/processes/resample/execution', 'application/json', "{\"inputs\":{\"$json\":1}}"));
    send_one('JSON string', $name, $post->('/v1/processes/resample/execution', 'application/json', "{\"inputs\":{\"method\":\"$json\"}}"));
    send_one('file name', $name, $post->('/v1/resample?points=9', 'multipart/form-data; boundary=b',
        "--b\r\nContent-Disposition: form-data; name=\"$json\"; filename=\"$json\"\r\n\r\n$cloud\r\n--b--\r\n"));
    send_one('magic', $name, $post->('/v1/resample?points=9', 'application/ply', $value));
}
Sockets::row('G19', "answers with raw bytes of $asked requests, " . keys(%count) . ' fields', $raw_bytes, 0, !$raw_bytes);
my $listed = $daemon->get('/v1/jobs?limit=100')->{content};
my $sound = eval { JSON::PP->new->utf8->decode($listed); 1 } ? 0 : 1;
Sockets::row('G19', 'lists of jobs with these names that are no JSON', $sound, 0, !$sound);
my @lines = split /\n/, $daemon->log_text;
my $broken = grep { !eval { JSON::PP->new->utf8->decode($_); 1 } } @lines;
Sockets::row('G19', 'lines of the log that are no JSON, of ' . @lines, $broken, 0, !$broken);
my $hidden = grep { /[\0-\x08\x0b-\x1f\x7f]/ } @lines;
Sockets::row('G19', 'lines of the log with a control byte', $hidden, 0, !$hidden);
$daemon->stop;
