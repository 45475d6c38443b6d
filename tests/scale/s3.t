#!/usr/bin/perl
# Blobs in S3: a Swift with its S3 interface is started here, which checks signatures, and a proxy before it that cuts connections.
use strict;
use warnings;
use Digest::SHA qw(hmac_sha256 sha256_hex);
use FindBin;
use lib "$FindBin::Bin/../support", $FindBin::Bin;
use POSIX ();
use Scale;
use Test::More;
use Vt;

ok start_swift(), 'Swift serves' or BAIL_OUT Vt::slurp("$Scale::dir/proxy.out");
my $cutter = start_cutter(sub { 20_000 + int rand 200_000 });

# --- daemons ----------------------------------------------------------------------------------------------------------------------

my $cloud = sphere_ply(4000);
my $plain = Vt->start(jobs => 2);
my $wanted = $plain->post('/v1/resample?points=800', $cloud)->{content};
my $place = "s3:http://127.0.0.1:$cutter/bucket/some/prefix";
my $daemon = Vt->start(blobs => $place, jobs => 2);
my @ids = map { $daemon->submit('points=800', $cloud) } 1 .. 10;
is scalar(grep { $daemon->finish($_)->{status} eq 'successful' } @ids), @ids, 'jobs end well though connections are cut';
is scalar(grep { $daemon->get("/v1/jobs/$_/results/cloud")->{content} eq $wanted } @ids), @ids, 'with the bytes of a daemon that has a folder';
is scalar(grep { m{^some/prefix/keep/[0-9a-f-]{36}\.cloud$} } objects()), @ids, 'which are in the bucket';

$daemon->stop('KILL');
my $next = Vt->start(dir => $daemon->{dir}, blobs => $place, 'blobs-cache' => 20_000);
is scalar(grep { $next->get("/v1/jobs/$_/results/cloud")->{content} eq $wanted } @ids), @ids, 'the next daemon fetches them';
my $kept = 0;
$kept += -s $_ for glob "$next->{dir}/data/cache/keep/*";
cmp_ok $kept, '<=', 20_000, 'and keeps as much of them as it may';
# An answer with these bytes, none of which a failure prints.
sub same {
    my ($answer, $bytes, $name) = @_;
    ok $answer->{content} eq $bytes, $name or diag "$answer->{status}: ", length $answer->{content}, ' bytes, want ', length $bytes;
}
my $part = $next->get("/v1/jobs/$ids[0]/results/cloud", headers => { Range => 'bytes=100-199' });
is $part->{status}, 206, 'a range of one';
same($part, substr($wanted, 100, 100), 'is a part of it');
is $next->request('HEAD', "/v1/jobs/$ids[1]/results/cloud")->{headers}{'content-length'}, length $wanted, 'a HEAD';
same($next->get("/v1/jobs/$ids[2]/input"), $cloud, 'an input');
my $draco = $next->get("/v1/jobs/$ids[3]/results/cloud?format=drc");
is $draco->{status}, 200, 'one in another format';
same($next->get("/v1/jobs/$ids[3]/results/cloud?format=drc"), $draco->{content}, 'and again');
same($next->post("/v1/resample?points=800&input=job:$ids[4]", ''), $wanted, 'an input of before is run again');

$next->request('DELETE', "/v1/jobs/$ids[0]");
ok wait_until(sub { !grep { /\Q$ids[0]\E/ } objects() }), 'the files of a deleted job are deleted';
Scale::put_object("some/prefix/keep/$ids[5].cloud", $wanted =~ s/.\z/!/sr);
$next->stop;
$next = Vt->start(dir => $daemon->{dir}, blobs => $place);
is_problem($next->get("/v1/jobs/$ids[5]/results/cloud"), 500, 'damaged-bytes', 'a damaged object is not sent');

# Of many results of which the database knows no job those stay that are no older than results become.
$next->stop;
my @strays = map { my $made = $_; map { "$made-7f7a-9d3e-2a6c1f0b8e1$_.cloud" } 0 .. 9 } substr($ids[5], 0, 13), '0193b5f2-7c1e';
Scale::put_object("some/prefix/keep/$_", 'ten bytes.') for @strays;
$next = Vt->start(dir => $daemon->{dir}, blobs => $place, 'admin-listen' => '127.0.0.1:0');
ok wait_until(sub { join(' ', @strays[0 .. 9]) eq join ' ', sort map { m{keep/(.*-2a6c1f0b8e.*)} } objects() }), 'young results without a job stay where there are many, old ones go';

# A number of a daemon; the most bytes that wait for who listens at a port.
sub counted { return HTTP::Tiny->new->get('http://' . ($_[1] // $next)->{admin} . '/metrics')->{content} =~ /^voronoid_\Q$_[0]\E (\d+)/m ? $1 : 0 }
sub queued { my $port = sprintf '%04X', $_[0]; return (sort { $b <=> $a } map { hex } Vt::slurp('/proc/net/tcp') =~ /^ *\d+: \w+:$port \S+ \S+ \w+:(\w+)/mg)[0] }
my $long = $next->submit('points=1000&iterations=300&delta=0', $cloud);
ok wait_until(sub { $next->status($long) eq 'running' }), 'while a job runs S3 goes away';
end_child('cutter');
my $away = $next->get("/v1/jobs/$ids[6]/results/cloud");
is_problem($away, 503, 'store-unavailable', 'a result that is not here is not to be had');
is $next->get('/livez')->{status}, 200, 'the daemon lives';
is $next->post('/v1/resample?points=100', $cloud)->{status}, 503, 'a submit is told to come again';
my $ready = $next->get('/readyz');
is_problem($ready, 503, 'store-unavailable', 'the daemon is not ready');
like json($ready)->{detail}, qr/^--blobs: S3 at .*(?:connect|refused)/, 'and says what is away';
ok counted('blob_errors_total{reason="away"}'), 'as do its numbers';
ok wait_until(sub { !counted('storage_up{part="blobs"}') }), 'in two places';
ok wait_until(sub { $next->log_text =~ /"msg":"a job waits for its files","job":"$long"/ }), 'the job waits with its result';
start_cutter(sub { 20_000 + int rand 200_000 }, $cutter);
ok wait_until(sub { $next->get("/v1/jobs/$ids[6]/results/cloud")->{content} eq $wanted }), 'which is there once S3 is';
ok wait_until(sub { $next->get('/readyz')->{status} == 200 }), 'the daemon is ready';
like json($next->get("/v1/jobs/$long"))->{status}, qr/running|successful/, 'the job is not lost';
is $next->finish($long)->{status}, 'successful', 'and ends';
my $unwanted = $next->submit('points=1000&iterations=300&delta=0', $cloud);
ok wait_until(sub { $next->status($unwanted) eq 'running' }), 'while a job runs S3 hangs';
kill 'STOP', $Scale::pid{proxy};
my $again = counted('blob_retries_total');
ok wait_until(sub { queued($Scale::swift{proxy}) >= 4096 }), 'and has been sent the result';
is $next->request('DELETE', "/v1/jobs/$unwanted")->{status}, 200, 'the job is dismissed';
ok wait_until(sub { !counted('queue_jobs{state="running"}') }), 'and ends';
is counted('blob_retries_total'), $again, 'without waiting for S3';
kill 'CONT', $Scale::pid{proxy};
is $next->finish($next->submit('points=100', $cloud))->{status}, 'successful', 'and another one ends well';

# With an address of the bucket for clients, a result is a link to it, which is good for two minutes and for nothing else.
my $linked = Vt->start(dir => do { $next->stop; $next->{dir} }, blobs => $place, 'blobs-public-url' => "http://127.0.0.1:$Scale::swift{proxy}/bucket/");
my $path = "/v1/jobs/$ids[6]/results/cloud";
sub link_of { return $linked->request($_[0], $path, $_[1] ? (headers => $_[1]) : ())->{headers}{location} }
my ($outside, $answer) = (HTTP::Tiny->new, $linked->get($path));
is $answer->{status}, 307, 'a result is elsewhere';
is $answer->{headers}{etag}, '"' . sha256_hex($wanted) . '"', 'with this digest';
like $answer->{headers}{location}, qr{\Ahttp://127.0.0.1:\d+/bucket/some/prefix/keep/$ids[6]\.cloud\?.*&X-Amz-Expires=120&}, 'under a link';
my $there = $outside->get($answer->{headers}{location});
same($there, $wanted, 'which has the bytes');
like $there->{headers}{'content-disposition'}, qr/\Aattachment; filename="[\w.-]+\.ply"\z/, 'and the name of the file';
is $there->{headers}{'content-type'}, 'application/ply', 'and its type';
same($outside->get(link_of('GET', { Range => 'bytes=100-199' }), { headers => { Range => 'bytes=100-199' } }), substr($wanted, 100, 100), 'a range');
is $outside->head(link_of('HEAD'))->{headers}{'content-length'}, length $wanted, 'a HEAD';
is $outside->delete(link_of('GET'))->{status}, 403, 'it is good for nothing else';
is $outside->get(link_of('GET') =~ s/Expires=120/Expires=121/r)->{status}, 403, 'nor when it is changed';
is $outside->get(signed_at(time - $_->[0], link_of('GET')))->{status}, $_->[1], "$_->[0] s later: $_->[1]" for [60, 200], [180, 403];
same($linked->get("$path?link=false"), $wanted, 'who wants to has the bytes from the daemon');
is $linked->get($path, headers => { 'If-None-Match' => $answer->{headers}{etag} })->{status}, 304, 'as does one who has them already';
is $linked->get("$path?format=drc")->{status}, 200, 'another format';
is $linked->get("/v1/jobs/$ids[6]/results/report")->{status}, 200, 'and what is no file';
my $fetch = "@{[$ENV{VORONOID} // 'build/release/voronoid']} fetch --server $linked->{url} $ids[6] --result cloud -qfo $Scale::dir/fetched.ply 2>&1";
is `$fetch` . $?, '0', 'our own client follows';
ok Vt::slurp("$Scale::dir/fetched.ply") eq $wanted, 'to the bytes';
Scale::put_object("some/prefix/keep/$ids[6].cloud", $wanted =~ s/.\z/!/sr);
like `$fetch` . ($? >> 8), qr/the file is damaged: its SHA-256 is .*\n1\z/, 'and sees when they are others';
unlike $linked->log_text, qr/X-Amz-Signature|secret-word/, 'the log has no link';
$linked->stop;
$next = Vt->start(dir => $linked->{dir}, blobs => $place, 'admin-listen' => '127.0.0.1:0');

# The same link as of another time, signed as the documentation of AWS has it.
sub signed_at {
    my ($time, $link) = @_;
    my ($host, $file, $query) = $link =~ m{\Ahttp://([^/]+)([^?]+)\?(.*)&X-Amz-Signature=};
    my $date = POSIX::strftime('%Y%m%dT%H%M%SZ', gmtime $time);
    my ($day, $key) = (substr($date, 0, 8), 'AWS4secret-word');
    $query =~ s/(X-Amz-Date=)\w+/$1$date/;
    $query =~ s/%2F\d{8}%2F/%2F$day%2F/;
    $key = hmac_sha256($_, $key) for $day, qw(us-east-1 s3 aws4_request);
    my $digest = sha256_hex("GET\n$file\n$query\nhost:$host\n\nhost\nUNSIGNED-PAYLOAD");
    my $signature = unpack 'H*', hmac_sha256("AWS4-HMAC-SHA256\n$date\n$day/us-east-1/s3/aws4_request\n$digest", $key);
    return "http://$host$file?$query&X-Amz-Signature=$signature";
}

# A file above 64 MiB goes part by part; the bucket may be a part of the host's name.
my $host = "s3:http://localhost:$Scale::swift{proxy}/bucket/large?style=host";
my $large = Vt->start(blobs => $host, 'blobs-cache' => 0);
my $padded = $cloud =~ s/(?=^end_header)/element padding 1\nproperty list int uchar bytes\n/mr . pack('l<', 70_000_000) . 'x' x 70_000_000;
my $id = $large->submit('points=100', $padded);
is $large->finish($id)->{status}, 'successful', 'a large input is taken';
ok wait_until(sub { 2 == grep { /^large\/keep\/\Q$id\E/ } objects() }), 'and stored, as is the result';
$large->stop;
$large = Vt->start(dir => $large->{dir}, blobs => $host, 'http-threads' => 1);
sub part { my ($from, $to) = @_; return $large->get("/v1/jobs/$id/input", headers => { Range => "bytes=$from-$to" }) }
sub here { return grep { /upload/ } glob "$large->{dir}/data/cache/keep/*" }
same(part(2_000_000, 5_000_000), substr($padded, 2_000_000, 3_000_001), 'a part of it comes');
ok !here(), 'without the others';
kill 'STOP', $Scale::pid{proxy};
my $waits = $large->connect;
syswrite $waits, "POST /v1/resample?points=100&input=job:$id HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nPrefer: respond-async\r\nConnection: close\r\n\r\n";
is $large->get('/livez')->{status}, 200, 'who waits for an input of before holds up nobody' for 1 .. 3;
kill 'CONT', $Scale::pid{proxy};
like Vt::read_all($waits), qr{\AHTTP/1.1 201 }, 'and is answered then';
same($large->get("/v1/jobs/$id/input"), $padded, 'and comes back');
$large->stop;
substr(my $spoiled = $padded, 2_500_000, 1) = '!';
Scale::put_object("large/keep/$id.upload", $spoiled);
$large = Vt->start(dir => $large->{dir}, blobs => $host, 'admin-listen' => '127.0.0.1:0');
my ($head, $sent) = split /\r\n\r\n/, $large->raw("GET /v1/jobs/$id/input HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"), 2;
ok $head =~ /\AHTTP\/1.1 500 / || ($head =~ /\AHTTP\/1.1 200 / && index($padded, $sent) == 0 && length $sent <= 2 << 20), 'of one whose third piece is damaged no more than two are sent';
is_problem(part(2_500_100, 2_500_199 + ($_ << 20)), 500, 'damaged-bytes', 'nor is any of the third one') for 0 .. 39;
same(part($_, $_ + 99), substr($padded, $_, 100), 'others are') for 2_000_000, 3_200_000, 4_194_250;
ok !here(), 'no copy is made';
cmp_ok counted('blob_errors_total{reason="damaged"}', $large), '>=', 2, 'and it is counted';
$large->stop;
Scale::put_object("large/piece/$id.upload", 'of no use');
$large = Vt->start(dir => $large->{dir}, blobs => $host);
is_problem($large->get("/v1/jobs/$id/input"), 500, 'damaged-bytes', 'without the digests of its pieces it is checked whole');
$large->request('DELETE', "/v1/jobs/$id");
ok wait_until(sub { !grep { /\Q$id\E/ } objects() }), 'the digests go with the file';
$large->stop;

Scale::start_proxy('another-word');
ok wait_until(sub { $next->get("/v1/jobs/$ids[7]/results/cloud")->{status} == 500 }), 'the secret is changed';
is_problem($next->get("/v1/jobs/$ids[7]/results/cloud"), 500, 'storage-refused', 'a result is not to be had');
ok counted('blob_errors_total{reason="refused"}'), 'which is counted';
ok wait_until(sub { json($next->get('/readyz'))->{detail} // '' =~ /^--blobs: .*403 SignatureDoesNotMatch/ }), 'the daemon is not ready';
Scale::start_proxy();
ok wait_until(sub { $next->get("/v1/jobs/$ids[7]/results/cloud")->{content} eq $wanted }), 'until it is the old one again';

# What is refused, each in one line without the secret.
for my $case (
    ['a wrong secret', "http://127.0.0.1:$Scale::swift{proxy}/bucket", qr/answered GET with status 403 SignatureDoesNotMatch/, AWS_SECRET_ACCESS_KEY => 'secret-word2'],
    ['an unknown bucket', "http://127.0.0.1:$Scale::swift{proxy}/none", qr/status 404 NoSuchBucket/],
    ['no key', "http://127.0.0.1:$Scale::swift{proxy}/bucket", qr/need keys: set AWS_ACCESS_KEY_ID/, AWS_ACCESS_KEY_ID => undef],
    ['a file that is not there', "http://127.0.0.1:$Scale::swift{proxy}/bucket", qr{/nowhere: No such file}, AWS_SECRET_ACCESS_KEY => undef, AWS_SECRET_ACCESS_KEY_FILE => '/nowhere'],
    ['a password in the URL', 'https://a:secret-word@host/bucket', qr/without user or password/],
    ['no bucket', 'https://host', qr{blobs is "s3:https://host", want s3:https://HOST/BUCKET}], ['another scheme', 'ftp://host/bucket', qr{blobs is "s3:ftp://host/bucket", want s3:https://HOST}],
    ['nobody there', 'http://127.0.0.1:1/bucket', qr/Failed to connect/]
) {
    my ($name, $url, $why, %set) = @$case;
    local @ENV{keys %ENV} = values %ENV;
    defined $set{$_} ? ($ENV{$_} = $set{$_}) : delete $ENV{$_} for keys %set;
    my ($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', "$Scale::dir/refused", '--blobs', "s3:$url");
    is $status, 1, "$name is refused";
    like $text, $why, 'with the reason';
    unlike $text, qr/secret-word/, 'and no secret';
}
unlike $_->log_text, qr/secret-word/, 'nor is it in a log' for $daemon, $next;
done_testing;
