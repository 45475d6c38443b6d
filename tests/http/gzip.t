#!/usr/bin/perl
# Bodies with Content-Encoding: gzip: the same results as without, and the limits hold for what they inflate to.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use FindBin;
use File::Temp qw(tempdir);
use IO::Compress::Gzip qw(gzip);
use IO::Compress::Deflate qw(deflate);
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $dir = tempdir(CLEANUP => 1);
my $daemon = Vt->start('body-limit' => '3M');
my $cloud = sphere_ply(500);
my $query = 'points=100&iterations=2&polish=0';

sub packed {
    my ($bytes, %options) = @_;
    my $out;
    gzip(\$bytes, \$out, -Time => 0, %options);
    return $out;
}

sub sent {
    my ($path, $bytes, %headers) = @_;
    return $daemon->post($path, $bytes, 'Content-Encoding' => 'gzip', %headers);
}

my $raw = $daemon->post("/v1/resample?$query", $cloud);
is $raw->{status}, 200, 'a body as it is is served' or diag $raw->{content};
for my $path ('/v1/resample', '/v1/processes/resample/execution') {
    my $answer = sent("$path?$query", packed($cloud));
    is $answer->{status}, 200, "$path serves gzip" or diag $answer->{content};
    ok $answer->{content} eq $raw->{content}, 'with the same bytes';
}
ok sent("/v1/resample?$query", packed($cloud), 'Content-Encoding' => $_)->{content} eq $raw->{content}, "$_ is gzip" for 'GZIP', 'x-gzip';
ok $daemon->post("/v1/resample?$query", $cloud, 'Content-Encoding' => 'identity')->{content} eq $raw->{content}, 'identity is none';
ok sent("/v1/resample?$query", packed($cloud, -Level => 0))->{content} eq $raw->{content}, 'without compressing';
ok sent("/v1/resample?$query", packed(substr $cloud, 0, 999) . packed(substr $cloud, 999))->{content} eq $raw->{content}, 'in two members';
{
    spew("$dir/x.ply.gz", packed($cloud));
    my @curl = ('curl', '-s', '-m', 60);
    for my $how (['--data-binary', "\@$dir/x.ply.gz"], ['--data-binary', "\@$dir/x.ply.gz", '-H', 'Transfer-Encoding: chunked'],
        ['-X', 'POST', '-T', "$dir/x.ply.gz"]) {
        open my $in, '-|', @curl, '-H', 'Content-Encoding: gzip', @$how, "$daemon->{url}/v1/resample?$query" or die;
        local $/;
        ok scalar(<$in>) eq $raw->{content}, "curl $how->[0] sends it";
    }
    open my $in, '-|', @curl, '-F', 'points=100', '-F', 'iterations=2', '-F', 'polish=0', '-F',
        "file=\@$dir/x.ply.gz;headers=\"Content-Encoding: gzip\"", "$daemon->{url}/v1/resample" or die;
    local $/;
    ok scalar(<$in>) eq $raw->{content}, 'a file of a form may be gzip';
}
my $job = json(sent("/v1/resample?$query", packed($cloud), Prefer => 'respond-async'))->{jobID};
is_deeply [@{ $daemon->finish($job)->{voronoid}{input} }{qw(format points bytes sha256)}],
    ['ply', 500, length $cloud, sha256_hex($cloud)], 'the job tells of the input as it was before';

# A request sent again is the same whether its input comes as gzip or not.
my @async = (Prefer => 'respond-async');
my $jobs = sub { scalar @{ json($daemon->get('/v1/jobs?limit=1000'))->{jobs} } };
my $again = sub { my ($answer) = @_; return join ' ', $answer->{status}, json($answer)->{jobID} // '', $answer->{headers}{'idempotent-replayed'} // 'no' };
for my $first ('plain', 'packed') {
    my %send = (
        plain => sub { $daemon->post("/v1/resample?$query", $_[0], 'Idempotency-Key' => $first, @async) },
        packed => sub { sent("/v1/resample?$query", packed($_[0], -Level => $_[1] // 6), 'Idempotency-Key' => $first, @async) });
    my $id = json($send{$first}->($cloud))->{jobID};
    my $before = $jobs->();
    is $again->($send{plain}->($cloud)), "201 $id true", "first $first, then as it is: the same job";
    is $again->($send{packed}->($cloud)), "201 $id true", "first $first, then as gzip";
    is $again->($send{packed}->($cloud, 1)), "201 $id true", "first $first, then compressed in another way";
    my $other = $send{packed}->(sphere_ply(501));
    is_problem($other, 422, 'idempotency-key-reused', "first $first, then another cloud as gzip");
    like json($other)->{detail}, qr/ belongs to job \Q$id\E/, 'which is named';
    is $jobs->(), $before, 'no job more';
    $daemon->finish($id);
}

# Other codings.
for my $coding ('br', 'deflate', 'zstd', 'compress', 'gzip, gzip', 'identity, gzip', 'gzip;q=1', 'gz') {
    my $answer = $daemon->post("/v1/resample?$query", packed($cloud), 'Content-Encoding' => $coding);
    refused($answer, 415, 'unsupported-format', qr/^Content-Encoding is \Q$coding\E, want gzip, once, or none$/, "the coding $coding");
    is $answer->{headers}{'accept-encoding'}, 'gzip', 'the answer has the one there is';
}
my $two = $daemon->raw("POST /v1/resample?$query HTTP/1.1\r\nHost: localhost\r\nContent-Encoding: gzip\r\nContent-Encoding: gzip\r\n"
    . "Content-Length: 5\r\nConnection: close\r\n\r\n12345");
like $two, qr{\AHTTP/1\.1 415 .*want gzip, once}s, 'two codings on two lines';

# What is no gzip, or not all of it.
my $whole = packed($cloud);
my $broken = $whole;
substr($broken, length($broken) / 2, 1) ^= "\x10";
my $crc = $whole;
substr($crc, -8, 1) ^= "\x01";
my $deflated;
deflate(\$cloud, \$deflated);
for my $case (
    ['nothing', '', 422, 'empty-cloud', qr/is empty: 0 bytes/],
    ['gzip of nothing', packed(''), 422, 'empty-cloud', qr/is empty: 0 bytes/],
    ['a cloud', $cloud, 400, 'malformed-request', qr/^the gzip body is not gzip at byte/],
    ['zlib', $deflated, 400, 'malformed-request', qr/is not gzip/],
    ['gzip cut short', substr($whole, 0, -1), 400, 'malformed-request', qr/is cut short at byte (\d+) of \1$/],
    ['the beginning of gzip', substr($whole, 0, 5), 400, 'malformed-request', qr/is cut short/],
    ['gzip and more', "${whole}more", 400, 'malformed-request', qr/has data after its end at byte ${\length $whole} of/],
    ['gzip and zeros', $whole . "\0" x 512, 400, 'malformed-request', qr/has data after its end/],
    ['gzip with a changed byte', $broken, 400, 'malformed-request', qr/is damaged/],
    ['gzip with another checksum', $crc, 400, 'malformed-request', qr/is damaged/],
    ['gzip twice', packed($whole), 415, 'unsupported-format', qr{^the input is gzip, want PLY or Draco: unpack it with gunzip, or send it over HTTP with Content-Encoding: gzip$}],
    ['gzip of rubbish', packed('rubbish'), 415, 'unsupported-format', qr/begins with "rubbish/],
    ['gzip of half a cloud', packed(substr $cloud, 0, 3000), 422, 'undecodable-cloud', qr/./],
) {
    my ($name, $bytes, $status, $slug, $detail) = @$case;
    refused(sent("/v1/resample?$query", $bytes), $status, $slug, $detail, $name);
}

# The limits count what comes of it.
my $noise = join '', map { pack 'N', ($_ * 2654435761) % 4294967296 } 1 .. 786433;
refused(sent("/v1/resample?$query", packed($noise, -Level => 1)), 413, 'too-many-bytes', qr/./, 'a body beyond the limit');
my $ply = "ply\nformat binary_little_endian 1.0\ncomment @{[ 'x' x 3_200_000 ]}\n";
my $bomb = packed($ply, -Level => 9);
cmp_ok length $bomb, '<', 3_200_000 / 900, 'a bomb is small';
my $answer = sent("/v1/resample?$query", $bomb);
refused($answer, 413, 'too-many-bytes', qr/^the gzip body of \d+ bytes inflates to more than 1048576 bytes, want at most 100 times its size or 1 MiB, whichever is more$/, 'a bomb');
is json($answer)->{limit}, 1048576, 'the limit is told';
my $half = substr($noise, 0, 40_000) . "\0" x 3_200_000;
refused(sent("/v1/resample?$query", packed($half)), 413, 'too-many-bytes', qr/inflates to more than 3145728 bytes$/,
    'one that keeps to the ratio and not to the limit of bodies');
is scalar(() = $daemon->blobs), 2 * (grep { /\.cloud$/ } $daemon->blobs),
    'nothing is left of what was refused';
is scalar(grep { $_->{status} && $_->{status} =~ /^5/ } $daemon->log_lines), 0, 'nothing was our own fault';
is $daemon->stop, 0, 'it ends with 0';
done_testing;
