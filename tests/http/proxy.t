#!/usr/bin/perl
# Behind a proxy: links, the log and the checks of Host and Origin by what trusted proxies say, and by
# nothing that others do.
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $cloud = sphere_ply(300);
my $daemon;

# A raw request: status, head, body.
sub with {
    my ($method, $path, @headers) = @_;
    my $lines = '';
    while (my ($name, $value) = splice @headers, 0, 2) { $lines .= "$name: $value\r\n" }
    my $raw = $daemon->raw("$method $path HTTP/1.1\r\n${lines}Connection: close\r\n\r\n");
    my ($code) = $raw =~ m{\AHTTP/1\.1 (\d+)};
    return ($code // 'none', head_of($raw), body_of($raw));
}

# The address that links begin with, or the status of a refusal.
sub base {
    my ($code, undef, $body) = with('GET', '/', @_);
    return $code if $code ne 200;
    my @hrefs = map { $_->{href} } @{ json($body)->{links} };
    my ($base) = $hrefs[0] =~ m{\A(.*)/v1/\z} or return "odd: $hrefs[0]";
    return (grep { index($_, "$base/") != 0 } @hrefs) ? "mixed: @hrefs" : $base;
}

my @x = ('X-Forwarded-For' => '192.0.2.1', 'X-Forwarded-Proto' => 'https',
    'X-Forwarded-Host' => 'cloud.example', 'X-Forwarded-Prefix' => '/clouds');
my @forwarded = (Forwarded => 'for="[2001:db8::1]:4711";proto=https;host="other.example:8443"');

# Settings.
for my $case (
    [['--trusted-proxy', 'localhost'], qr/--trusted-proxy holds "localhost", want addresses and networks such as/],
    [['--trusted-proxy', '10.0.0.0/8,10.0.0.0/33'], qr{holds "10\.0\.0\.0/33"}],
    [['--trusted-proxy', '127.0.0.1', '--trusted-proxy=::/129'], qr{holds "::/129"}],
    [['--trusted-proxy', 'unix'], qr/holds "unix"/],
    [['--proxy-headers', 'via'], qr/--proxy-headers is "via", want one of x-forwarded forwarded/],
    [['--allowed-hosts', 'https://cloud.example'], qr{holds "https://cloud\.example", want names such as}],
    [['--allowed-hosts', 'cloud.example:80'], qr/without scheme and port/],
    [['--public-url', 'https://cloud.example/a/../b'], qr/want http:/],
    [['--public-url', 'https://cloud.example:port/'], qr/want http:/],
    [['--blobs-public-url', 'https://a:secret@host'], qr/--blobs-public-url is "...", want http:/], [['--blobs-public-url', 'http://host'], qr/needs --blobs s3:/],
    [['--public-url', 'https://user@cloud.example'], qr/want http:/],
    [['--public-url', 'https://cloud.example/' . 'a' x 130], qr/a path may follow \(128 bytes at most\)/],
    [['--public-url', "https://cloud.example/\x01"], qr/want http:/],
) {
    my ($arguments, $message) = @$case;
    my ($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', tempdir(CLEANUP => 1), @$arguments);
    my $name = join ' ', map { substr $_, 0, 60 } @$arguments;
    is $status, 2, "$name: exit status 2";
    like $text, $message, "$name: a message with value and range";
}

# No proxy is trusted: nobody is believed.
$daemon = Vt->start;
my @own = (Host => $daemon->{address});
is base(@own), $daemon->{url}, 'without a proxy links go by Host';
is base(@own, @x, @forwarded), $daemon->{url}, 'and not by headers of proxies';
is base(Host => 'cloud.example'), 403, 'whose Host is refused';
is $daemon->stop, 0, 'it ends with 0';
is_deeply [grep { $_->{msg} eq 'request' && $_->{client} ne '127.0.0.1' } $daemon->log_lines], [],
    'the log has the address of the connection';

# The peer is not the proxy that is trusted.
$daemon = Vt->start('no-auth' => 1, 'trusted-proxy' => '10.0.0.0/8,127.0.0.2');
@own = (Host => $daemon->{address});
is base(@own, @x), $daemon->{url}, 'who is not trusted is not believed';
is $daemon->stop, 0, 'it ends with 0';
ok !(grep { ($_->{client} // '') eq '192.0.2.1' } $daemon->log_lines), 'nor logged by what it says';

# X-Forwarded-*, the default.
$daemon = Vt->start('no-auth' => 1, 'trusted-proxy' => '127.0.0.0/8, fd00::/8');
@own = (Host => $daemon->{address});
is base(@own), $daemon->{url}, 'a trusted proxy that says nothing changes nothing';
is base(@own, @x), 'https://cloud.example/clouds', 'scheme, host and prefix make the links';
is base(@own, @x, @forwarded), 'https://cloud.example/clouds', 'Forwarded is ignored';
is base(@own, @forwarded), $daemon->{url}, 'alone as well';
is base(Host => 'cloud.example', @x), 'https://cloud.example/clouds', 'a proxy may let Host through';
is base(Host => 'cloud.example'), 403, 'which alone is refused';
is base(@own, 'X-Forwarded-Proto' => 'https'), "https://$daemon->{address}", 'a scheme alone is used';
is base(@own, 'X-Forwarded-Host' => 'evil.example, cloud.example:8443'), 'http://cloud.example:8443',
    'of several hosts the last one counts';
for my $odd (['X-Forwarded-Proto' => 'ftp'], ['X-Forwarded-Host' => 'a/b'], ['X-Forwarded-Prefix' => '//evil'],
    ['X-Forwarded-Host' => 'user@evil.example'], ['X-Forwarded-Prefix' => '/a"b'], ['X-Forwarded-For' => 'x"y'])
{
    is base(@own, @$odd), $daemon->{url}, "$odd->[0]: $odd->[1] is ignored";
}
my ($code, $head, $body) = with('GET', '/v1/jobs/none', @own, @x);
like $body, qr{"type":"http://www.opengis.net/}, 'a problem of OGC keeps its type';
($code, $head, $body) = with('DELETE', '/version', @own, @x);
like $body, qr{"type":"https://cloud\.example/clouds/problems/method-not-allowed"}, 'ours goes by the proxy';

my $made = $daemon->post('/v1/resample?points=50&iterations=1', $cloud, Prefer => 'respond-async', @x);
is $made->{status}, 201, 'a job is made through a proxy';
like $made->{headers}{location}, qr{\Ahttps://cloud\.example/clouds/v1/jobs/[0-9a-f-]+\z}, 'Location';
my $id = json($made)->{jobID};
$daemon->finish($id);
my $stream = $daemon->events("/v1/jobs/$id/events", headers => {@x});
my $documents = join "\n", (map { (with('GET', $_, @own, @x))[2] }
        '/v1/jobs', "/v1/jobs/$id", "/v1/jobs/$id/results", '/v1/processes', '/v1/processes/resample',
        '/v1/jobs?limit=1'), map { $_->{data} } $stream->all;
my @hrefs = $documents =~ m{"href":"([^"]+)"}g;
cmp_ok scalar @hrefs, '>', 15, 'the documents and the stream are full of links';
is_deeply [grep { !m{\Ahttps://cloud\.example/clouds/v1/} } @hrefs], [], 'all of them right';

# Origin by what the browser sees.
is +(with('POST', '/v1/resample?points=5', @own, @x, Origin => 'https://cloud.example', 'Content-Length' => 0))[0],
    422, 'the origin that the proxy stands for may submit';
is +(with('POST', '/v1/resample?points=5', @own, @x, Origin => "http://$daemon->{address}",
            'Content-Length' => 0))[0], 403, 'another may not';
is $daemon->stop, 0, 'it ends with 0';
my ($line) = grep { $_->{msg} eq 'request' && ($_->{job} // '') eq $id && $_->{method} eq 'POST' } $daemon->log_lines;
is $line->{client}, '192.0.2.1', 'the log has the client';

# Forwarded.
$daemon = Vt->start('no-auth' => 1, 'trusted-proxy' => '127.0.0.1', 'proxy-headers' => 'forwarded');
@own = (Host => $daemon->{address}, 'X-Request-Id' => 'seen');
is base(@own, @forwarded), 'https://other.example:8443', 'Forwarded makes the links';
is base(@own, @forwarded, @x), 'https://other.example:8443', 'X-Forwarded-* is ignored';
is base(@own, @x), $daemon->{url}, 'alone as well';
is base(@own, Forwarded => 'for="[2001:db8::1];host=evil.example'), $daemon->{url}, 'a malformed one too';
is $daemon->stop, 0, 'it ends with 0';
is_deeply [map { $_->{client} } grep { ($_->{request_id} // '') eq 'seen' } $daemon->log_lines],
    ['2001:db8::1', '2001:db8::1', '127.0.0.1', '127.0.0.1'], 'the log has the client';

# --public-url wins, and its host is one of ours; what a proxy says is held against it.
$daemon = Vt->start('no-auth' => 1, 'trusted-proxy' => '127.0.0.1', 'public-url' => 'https://named.example:8443/base/');
@own = (Host => $daemon->{address});
is base(@own), 'https://named.example:8443/base', '--public-url makes the links';
is base(Host => 'named.example'), 'https://named.example:8443/base', 'its Host is answered';
is base(@own, 'X-Forwarded-Host' => 'named.example:8443', 'X-Forwarded-Proto' => 'http'),
    'https://named.example:8443/base', 'also by way of a proxy';
is base(@own, @x), 403, 'another Host is not';
is base(Host => 'evil.example', 'X-Forwarded-Host' => 'named.example'), 403,
    'not even when a header of a proxy hides it';
is $daemon->stop, 0, 'it ends with 0';

# --allowed-hosts, here and where other machines may call.
$daemon = Vt->start('no-auth' => 1, 'trusted-proxy' => '127.0.0.1', 'allowed-hosts' => 'cloud.example, Other.example,[2001:db8::1]');
@own = (Host => $daemon->{address});
is base(@own, @x), 'https://cloud.example/clouds', 'a host of the list is answered';
is base(Host => 'other.example:90'), 'http://other.example:90', 'also without a proxy, at any port';
is base(Host => '[2001:db8::1]:90'), 'http://[2001:db8::1]:90', 'also as an address';
is base(@own, 'X-Forwarded-Host' => 'evil.example'), 403, 'one that is not there is refused';
is base(Host => 'evil.example', @x), 403, 'in Host as well';
is base(Host => 'cloud.example.evil'), 403, 'a name is compared whole';
is $daemon->stop, 0, 'it ends with 0';
$daemon = Vt->start(listen => '0.0.0.0:0', 'no-auth' => 1, 'allowed-hosts' => 'cloud.example');
is base(Host => 'cloud.example'), 'http://cloud.example', 'a list holds for an open daemon';
is base(Host => 'evil.example'), 403, 'others are refused there too';
is $daemon->stop, 0, 'it ends with 0';

# The compose file publishes its port where browsers run: to a page of a name that leads there the daemon is not open.
my ($command) = Vt::slurp('docker/compose.yaml') =~ /^    command: (\[.*\])$/m;
my (undef, @words) = @{ json($command) };
my %given;
while (my $flag = shift @words) { $given{ $flag =~ s/^--//r } = @words && $words[0] !~ /^--/ ? shift @words : 1 }
$daemon = Vt->start(listen => '0.0.0.0:0', %given);
is base(Host => $_), "http://$_", "the container answers $_" for 'localhost:8080', '127.0.0.1:8080';
is base(Host => 'evil.example:8080', Origin => 'http://evil.example:8080'), 403, 'and no name that was made to lead to it';
is $daemon->stop, 0, 'it ends with 0';
done_testing;
