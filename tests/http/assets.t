#!/usr/bin/perl
# The page's files: who gets them, in which coding, with which headers, and that a key is asked for by what they ask for.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use File::Temp qw(tempdir);
use FindBin;
use IO::Uncompress::Gunzip qw(gunzip);
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $policy = q{default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' blob:; }
    . q{worker-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'};
my $navigation = 'text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8';

# A daemon that wants a key, to see what comes without one.
my $dir = tempdir(CLEANUP => 1);
spew("$dir/keys", 'somebody:read:' . sha256_hex('a key of somebody') . "\n");
my $daemon = Vt->start('api-keys' => "$dir/keys");

my $landing = $daemon->get('/');
is $landing->{headers}{'content-type'}, 'application/json', 'who names no media type gets the landing document';
is_deeply [map { $_->{rel} } @{ json($landing)->{links} }], [map { $_->{rel} }
    @{ json($daemon->get('/v1', { headers => { 'X-API-Key' => 'a key of somebody' } }->%*))->{links} }],
    'which is that of the API';
for my $accept ('*/*', 'application/json', 'application/json, */*;q=0.1', 'text/*', 'text/html;q=0', 'text/html ; q=0.0, */*', '*/*, TEXT/HTML;Q=0',
    'text/html;q=0.5, application/json', 'text/html;charset=utf-8;q=0.2,application/json;q=0.3', 'text/htmlx', 'xtext/html') {
    is $daemon->get('/', headers => { Accept => $accept })->{content}, $landing->{content}, "and so does $accept";
}
for my $accept ('text/html', 'application/json;q=0.2, Text/HTML;q=0.3', 'text/html;q=0.001', 'application/json;q=0, text/html;q=0.1',
    '*/*, text/html;charset=utf-8', ['text/plain', 'text/html']) {
    is $daemon->request('HEAD', '/', headers => { Accept => $accept })->{headers}{'content-type'}, 'text/html; charset=utf-8',
        'the page comes for ' . (ref $accept ? "Accept in two lines, @$accept" : $accept);
}
my $page = $daemon->get('/', headers => { Accept => $navigation });
is $page->{headers}{'content-type'}, 'text/html; charset=utf-8', 'a browser gets the page, without a key';
like $page->{content}, qr/^<!doctype html>/i, 'as it is written, where it does not say that it reads gzip';
is $page->{headers}{vary}, 'Accept, Accept-Encoding', 'caches are told what it goes by';
is $landing->{headers}{vary}, 'Accept', 'of the document too';

my @names = $page->{content} =~ m{"assets/([\w.-]+)"}g;
cmp_ok scalar @names, '>=', 2, 'the page has a script and a style';
unlike $page->{content}, qr{(?:src|href)="(?:https?:)?//}, 'and nothing of another origin';
my %etags;
for my $path ('/', map { "/assets/$_" } 'index.html', @names) {
    my $plain = $daemon->get($path, headers => { Accept => 'text/html' });
    my $packed = $daemon->get($path, headers => { Accept => 'text/html', 'Accept-Encoding' => 'br, gzip;q=0.5' });
    is_deeply [@$_{qw(status)}], [200], "$path is there" for $plain, $packed;
    is $packed->{headers}{'content-encoding'}, 'gzip', 'gzipped for who reads that';
    is $plain->{headers}{'content-encoding'}, undef, 'and not for who does not';
    gunzip(\$packed->{content}, \my $inflated);
    is $inflated, $plain->{content}, 'the same file both times';
    is $packed->{headers}{etag}, '"' . sha256_hex($packed->{content}) . '"', 'a tag is the digest of the bytes';
    isnt $plain->{headers}{etag}, $packed->{headers}{etag}, 'other bytes have another tag';
    $etags{ $packed->{headers}{etag} }++;
    for my $answer ($plain, $packed) {
        my %headers = %{ $answer->{headers} };
        is $headers{'content-security-policy'}, $policy, 'the policy';
        is $headers{'referrer-policy'}, 'no-referrer', 'no referrer';
        is $headers{'x-content-type-options'}, 'nosniff', 'no sniffing';
        is $headers{'cache-control'}, 'no-cache', 'it is kept, and asked for again';
        my $again = $daemon->get($path, headers => { Accept => 'text/html', 'If-None-Match' => $headers{etag},
            $headers{'content-encoding'} ? ('Accept-Encoding' => 'gzip') : () });
        is $again->{status} . ($again->{content} // ''), '304', 'what has not changed comes without a body';
        is $again->{headers}{etag}, $headers{etag}, 'and with its tag';
    }
}
is scalar(keys %etags), @names + 1, 'every file has a tag of its own, the page one under both names';

my %types = (js => 'text/javascript', css => 'text/css', html => 'text/html', svg => 'image/svg+xml');
for my $name (@names) {
    my ($ending) = $name =~ /\.(\w+)$/;
    my $type = $daemon->request('HEAD', "/assets/$name")->{headers}{'content-type'};
    like $type, qr/^\Q$types{$ending}\E\b/, "$name has its media type";
}
for my $coding ('gzip;q=0', 'identity', '*;q=0', 'x-gzip', 'gzip; q=0, *') {
    is $daemon->get('/assets/index.html', headers => { 'Accept-Encoding' => $coding })->{headers}{'content-encoding'}, undef,
        "Accept-Encoding $coding is not gzip";
}
is $daemon->get('/assets/index.html', headers => { 'Accept-Encoding' => $_ })->{headers}{'content-encoding'}, 'gzip',
    "Accept-Encoding $_ is gzip" for '*', 'deflate, GZIP', 'gzip;q=0.001';
my $docs = $daemon->get('/docs');
is $docs->{headers}{'content-security-policy'}, $policy, 'the documentation has the policy of the page';
unlike $docs->{content}, qr{(?:src|href)="(?:https?:)?//}, 'and nothing of another origin';
is_deeply [$docs->{content} =~ m{<section id="(\w+)">}g], [Vt::slurp('server/base/topics.h') =~ /^ +X\((\w+), \d\)/mg, 'contract'],
    'every topic of the help is there, and the contract';
is_problem $daemon->get('/assets/none.js'), 404, 'no-such-resource', 'a file that the page does not have';
is_problem $daemon->get('/assets/voronoid.conf'), 404, 'no-such-resource', 'nor are there other files of the daemon';
is_problem $daemon->post('/assets/index.html', ''), 405, 'method-not-allowed', 'nobody writes to it';
is_problem $daemon->get($_), 401, 'unauthorized', "$_ needs the key" for '/v1/processes', '/v1/jobs';
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
