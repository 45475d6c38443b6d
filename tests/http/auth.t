#!/usr/bin/perl
# Who may do what: every route of the table with every kind of key, Host and Origin; jobs, keys of requests and lists of one
# key apart from those of another; tickets; and what a key may have of the daemon at most.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use File::Temp qw(tempdir);
use FindBin;
use IO::Compress::Gzip ();
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $dir = tempdir(CLEANUP => 1);
my %key = map { $_ => "secret-of-$_-" . 'x' x 20 } qw(alice bob reader sender root slow small stored six);
my $open_rate = 'jobs=1000,rate=10000';
my @lines = (
    "# who may call\n",
    line('alice', 'submit,read', $open_rate), line('bob', 'submit,read', $open_rate),
    line('reader', 'read', $open_rate), line('sender', 'submit', $open_rate), line('root', 'admin', $open_rate),
    line('slow', 'submit,read', 'jobs=3,rate=2'), line('small', 'submit,read', "$open_rate,points=500"),
    line('stored', 'submit,read', "$open_rate,bytes=9000"), line('six', 'submit,read', "$open_rate,bytes=600K"),
);
my $file = write_keys("$dir/keys", @lines);

sub line { return "$_[0]:$_[1]:" . sha256_hex($key{ $_[0] }) . ":$_[2]\n" }

sub write_keys {
    my ($path, @text) = @_;
    spew($path, @text);
    chmod 0600, $path;
    return $path;
}

my $daemon = Vt->start('api-keys' => $file, 'log-level' => 'debug', jobs => 1);
my $cloud = sphere_ply(300);

sub ask {
    my ($who, $method, $path, %with) = @_;
    my %headers = (%{ $with{headers} // {} }, defined $who ? (Authorization => "Bearer $key{$who}") : ());
    return $daemon->request($method, $path, headers => \%headers, content => $with{content} // '');
}

sub submit {
    my ($who, $query, %headers) = @_;
    my $answer = ask($who, 'POST', "/v1/resample?$query", content => $cloud, headers => { Prefer => 'respond-async', %headers });
    die "submit: $answer->{status} $answer->{content}" unless $answer->{status} == 201;
    return json($answer)->{jobID};
}

sub finish {
    my ($who, $id) = @_;
    my $info;
    wait_until(sub { ($info = json(ask($who, 'GET', "/v1/jobs/$id")))->{status} =~ /^(?:successful|failed|dismissed)$/ })
        or die "job $id does not end";
    return $info;
}

my $quick = 'points=50&iterations=2';
my $long = 'points=290&seconds=3600&delta=0&moveStop=0&iterations=10000&polish=10000';
my $job = submit('alice', $quick);
is finish('alice', $job)->{status}, 'successful', 'a job with a key ends well';

# --- the matrix -----------------------------------------------------------------------------------

my (undef, undef, $printed) = Vt::run('--print-routes');
my %open = map { $_ => 1 } '/', '/livez', '/readyz', '/version', '/openapi.yaml', '/openapi.json', '/docs', '/problems/{slug}',
    '/assets/{asset}';
my %lacking = (read => 'sender', submit => 'reader');
my $cells = 0;
my @wrong;
for my $line (split /\n/, $printed) {
    my ($method, $route, $scope) = split / /, $line;
    like $scope // '', $open{$route} ? qr/^open$/ : qr/^(?:read|submit|admin)$/, "$method $route has the scope it should have";
    my $path = $route =~ s/\{jobID\}/$job/r =~ s/\{slug\}/forbidden/r =~ s/\{processID\}/resample/r =~ s/\{output\}/cloud/r
        =~ s/\{asset\}/index.html/r =~ s/preview$/preview?points=0/r; # a job that is over shows nothing: 404, but for a 400
    for my $who ('none', 'bad', 'other', 'lacking', 'good') {
        for my $from ('here', 'rebound', 'foreign') {
            # A submit without a body is a 400 or 422, and a stop of a job that is over a 409: neither changes what comes after. A
            # job is removed last, by its own test below.
            next if $method eq 'DELETE' && $who eq 'good' && $from eq 'here';
            my $code = code_of($method, $path, headers_of($who, $scope, $from));
            my $good = $from ne 'here' ? $code == 403
                : $scope eq 'open' ? $code == 200
                : $who eq 'none' || $who eq 'bad' ? $code == 401
                : $who eq 'lacking' ? $code == 403
                : $who eq 'other' && $route =~ /jobID/ ? $code == 404
                : $code =~ /^(?:200|201|400|409|422)$/;
            push @wrong, "$method $route, key $who, from $from: $code" unless $good;
            $cells++;
        }
    }
}
is_deeply \@wrong, [], "all $cells cells of the matrix are as they should be";
cmp_ok $cells, '>', 400, 'and they are many';

sub headers_of {
    my ($who, $scope, $from) = @_;
    my %headers = (Host => $from eq 'rebound' ? 'evil.example' : "localhost:$daemon->{port}");
    my $name = { other => 'bob', good => 'alice', lacking => $lacking{$scope} // 'reader' }->{$who};
    $headers{Origin} = 'https://evil.example' if $from eq 'foreign';
    $headers{Authorization} = 'Bearer ' . (defined $name ? $key{$name} : 'vor_nothing') if $who ne 'none';
    return %headers;
}

sub code_of {
    my ($method, $path, %headers) = @_;
    my $lines = join '', map { "$_: $headers{$_}\r\n" } sort keys %headers;
    my $raw = $daemon->raw("$method $path HTTP/1.1\r\n${lines}Content-Length: 0\r\nConnection: close\r\n\r\n");
    return $raw =~ m{\AHTTP/1\.1 (\d+)} ? $1 : 0;
}

# --- refusals -------------------------------------------------------------------------------------

my $refused = ask(undef, 'GET', '/v1/jobs');
is_problem($refused, 401, 'unauthorized', 'no key');
is $refused->{headers}{'www-authenticate'}, 'Bearer realm="voronoid"', 'and what is wanted';
$refused = $daemon->get('/v1/jobs', headers => { Authorization => 'Bearer vor_nothing' });
is_problem($refused, 401, 'unauthorized', 'a key that is none');
like $refused->{headers}{'www-authenticate'}, qr/error="invalid_token"/, 'is told apart';
unlike $refused->{content}, qr/vor_nothing/, 'and not sent back';
$refused = ask('reader', 'POST', "/v1/resample?$quick", content => $cloud);
is_problem($refused, 403, 'forbidden', 'a scope that is missing');
like json($refused)->{detail}, qr/^the key reader has the scopes read, but this request also needs the scope submit$/, 'is named';
like $refused->{headers}{'www-authenticate'}, qr/error="insufficient_scope", scope="submit"/, 'for programs too';
is $daemon->get('/v1/jobs', headers => $_->[0])->{status}, $_->[1], $_->[2] for
    [{ 'X-API-Key' => $key{alice} }, 200, 'X-API-Key does'], [{ 'X-API-Key' => 'x' }, 401, 'unless it is none'],
    [{ Authorization => "bearer  $key{alice}" }, 200, 'Bearer is a word of any case'],
    [{ Authorization => 'Basic YTpi', 'X-API-Key' => $key{alice} }, 200, 'what a proxy wants is no matter'],
    [{ Authorization => "Basic $key{alice}" }, 401, 'Basic is no scheme of ours'],
    [{ Authorization => 'Bearer ' }, 401, 'an empty key is none'],
    [{ Authorization => "Bearer $key{alice} " . 'x' }, 401, 'nor is one with more behind it'];
is $daemon->get("/v1/jobs?key=$key{alice}")->{status}, 401, 'a query has no keys';
is $daemon->request('OPTIONS', '/v1/jobs')->{status}, 204, 'a preflight needs none';

# --- whose jobs -----------------------------------------------------------------------------------

my $of_bob = submit('bob', "$quick&name=bobs");
finish('bob', $of_bob);
my $theirs = ask('alice', 'GET', "/v1/jobs/$of_bob");
my $nobodys = ask('alice', 'GET', '/v1/jobs/0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11');
is_problem($theirs, 404, 'no-such-job', "another key's job");
is $theirs->{content} =~ s/\Q$of_bob\E/ID/gr =~ s/"(?:requestId|instance)":"[^"]*"//gr,
    $nobodys->{content} =~ s/0193b5f2[-0-9a-f]*/ID/gr =~ s/"(?:requestId|instance)":"[^"]*"//gr,
    'is answered like one that is none';
is_problem(ask('alice', 'POST', "/v1/resample?$quick&input=job:$of_bob"), 404, 'no-such-job', 'nor is its input to be had');
is ask('bob', 'POST', "/v1/resample?$quick&input=job:$of_bob")->{status}, 200, 'but by its own key';
sub listed { return map { $_->{jobID} } @{ json(ask($_[0], 'GET', '/v1/jobs?limit=100'))->{jobs} } }
is_deeply [listed('alice')], [$job], "a list has the key's jobs alone";
is_deeply [grep { $_ eq $job } listed('bob')], [], 'each its own';
is_deeply [sort grep { $_ eq $job || $_ eq $of_bob } listed('root')], [sort $job, $of_bob], 'admin sees all of them';
is ask('root', 'GET', "/v1/jobs/$_")->{status}, 200, 'one by one as well' for $job, $of_bob;

my @same = ("$quick&seed=7", 'Idempotency-Key' => '"one"');
my ($first, $again, $others) = (submit('alice', @same), submit('alice', @same), submit('bob', @same));
is $again, $first, 'a key of a request is that of one job';
isnt $others, $first, 'among those of its own caller';

# A stream, a result and a deletion, of a job that runs.
my $running = submit('alice', $long);
is ask('bob', $_->[0], "/v1/jobs/$running$_->[1]")->{status}, 404, "$_->[0] $_->[1] of another's running job is a 404"
    for ['GET', ''], ['GET', '/events'], ['GET', '/trace'], ['POST', '/stop'], ['DELETE', ''], ['GET', '/results/cloud'],
    ['POST', '/tickets'];
is json(ask('alice', 'GET', "/v1/jobs/$running"))->{status} =~ /^(?:accepted|running)$/, 1, 'and does nothing to it';
is ask('alice', 'DELETE', "/v1/jobs/$running")->{status}, 200, 'its own key ends it';

# --- tickets --------------------------------------------------------------------------------------

my $made = ask('alice', 'POST', "/v1/jobs/$job/tickets");
is $made->{status}, 201, 'a ticket is made';
my $ticket = json($made)->{ticket};
my ($link) = json($made)->{href} =~ m{^\Q$daemon->{url}\E(/.*)$};
is $link, "/v1/jobs/$job/results/cloud?ticket=$ticket", 'which leads to the main result';
is $made->{headers}{location}, json($made)->{href}, 'and is the Location';
is $daemon->get($link)->{content}, ask('alice', 'GET', "/v1/jobs/$job/results/cloud")->{content}, 'with it the result needs no key';
is $daemon->request('HEAD', $link)->{status}, 200, 'by HEAD too';
is $daemon->get("$link&format=drc")->{status}, 200, 'in another format as well';
is $daemon->get($_)->{status}, 401, "but nothing else: $_" for $link =~ s/cloud/report/r, $link =~ s/.\z//r,
    $link =~ s/\Q$job\E/$of_bob/r, "/v1/jobs/$job?ticket=$ticket", "/v1/jobs/$job/results?ticket=$ticket";
my $report = json(ask('alice', 'POST', "/v1/jobs/$job/tickets?output=report"))->{href} =~ s/^\Q$daemon->{url}\E//r;
is json($daemon->get($report))->{delta} > 0, 1, 'a document has tickets as well';
is_problem(ask('alice', 'POST', "/v1/jobs/$job/tickets?output=none"), 404, 'no-such-output', 'an output that is none');
is_problem(ask('alice', 'POST', "/v1/jobs/$job/tickets?x=1"), 400, 'invalid-query-parameter-value', 'a parameter that is none');
is_problem(ask('alice', 'POST', "/v1/jobs/$running/tickets"), 404, 'result-not-available', 'a job without a result');

# --- how much -------------------------------------------------------------------------------------

is_problem(ask('small', 'POST', '/v1/resample?points=50', content => sphere_ply(501)), 413, 'too-many-points', 'a quota of points');
is ask('small', 'POST', "/v1/resample?$quick", content => sphere_ply(499))->{status}, 200, 'which others fit';
my $fits = ask('stored', 'POST', "/v1/resample?$quick", content => $cloud);
is $fits->{status}, 200, 'a quota of bytes has room';
$refused = ask('stored', 'POST', "/v1/resample?$quick", content => sphere_ply(500));
is_problem($refused, 429, 'too-much-stored', 'until it has none');
my @pieces = unpack '(a1000)*', sphere_ply(500); # chunked: no length is declared
is_problem(ask('stored', 'POST', "/v1/resample?$quick", content => sub { shift @pieces }), 429, 'too-much-stored', 'whatever the length said');
my $padded = $cloud =~ s/^(.*?\n.*?\n)/$1 . ('comment ' . 'x' x 70 . "\n") x 64/er;
IO::Compress::Gzip::gzip(\$padded, \my $gzipped);
is_problem(ask('stored', 'POST', "/v1/resample?$quick", content => $gzipped, headers => { 'Content-Encoding' => 'gzip' }),
    429, 'too-much-stored', 'inflated bytes count');
ask('stored', 'DELETE', $fits->{headers}{location} =~ s/^\Q$daemon->{url}\E//r);
is ask('stored', 'POST', "/v1/resample?$quick", content => sphere_ply(500))->{status}, 200, 'a removed job makes room';

# Six uploads of which two are too many, all of them here but for their last bytes before any is complete.
my $large = sphere_ply(35_900);
IO::Compress::Gzip::gzip(\$large, \my $small_of_large);
my @six = map {
    my $head = "POST /v1/resample?$quick HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer $key{six}\r\n"
        . "Prefer: respond-async\r\nConnection: close\r\n";
    my $body = $_ % 3 == 2 ? $small_of_large : $large;
    $head .= $_ % 3 == 1 ? "Transfer-Encoding: chunked\r\n" : 'Content-Length: ' . length($body) . "\r\n";
    $head .= "Content-Encoding: gzip\r\n" if $_ % 3 == 2;
    $body = join '', map { sprintf("%x\r\n%s\r\n", length, $_) } unpack('(a50000)*', $body), '' if $_ % 3 == 1;
    my $socket = $daemon->connect;
    print $socket "$head\r\n", substr $body, 0, -4;
    [$socket, substr $body, -4];
} 0 .. 5;
print { $_->[0] } $_->[1] for @six;
$_->[0]->flush for @six;
my @answers = sort map { Vt::read_all($_->[0]) } @six;
is "@{[map { m{\AHTTP/1\.1 (\d+)} } @answers]}", '201 429 429 429 429 429', 'six uploads at once, chunked and gzip among them, are never over a quota';
finish('six', $answers[0] =~ m{^Location: \S+/v1/jobs/(\S+)}mi);

my @held = map { submit('slow', $long) } 1 .. 3;
$refused = ask('slow', 'POST', "/v1/resample?$quick", content => $cloud);
is_problem($refused, 429, 'too-many-jobs', 'a job more than the key may have');
like $refused->{headers}{'retry-after'}, qr/^\d+$/, 'with whole seconds';
is $refused->{headers}{'ratelimit-policy'}, '"jobs";q=4;w=2', 'the rate of the key is told with each answer';
like $refused->{headers}{ratelimit}, qr/^"jobs";r=[0-3];t=[12]$/, 'and what is left of it';
for (1 .. 20) { # more than two in a second, however slow the machine is
    $refused = ask('slow', 'POST', "/v1/resample?$quick", content => $cloud);
    last if $refused->{content} =~ /rate-limited/;
}
is_problem($refused, 429, 'rate-limited', 'and more requests than it may send');
is $refused->{headers}{'retry-after'}, 1, 'with the seconds until the next one';
is $refused->{headers}{ratelimit}, '"jobs";r=0;t=2', 'none is left, and in two seconds all are back';
my $flood = json(ask('slow', 'GET', "/v1/jobs/$held[2]"))->{voronoid}{queuePosition};
my $beside = submit('alice', $quick);
is json(ask('alice', 'GET', "/v1/jobs/$beside"))->{voronoid}{queuePosition}, 0, 'the first job of another key is next';
is json(ask('slow', 'GET', "/v1/jobs/$held[2]"))->{voronoid}{queuePosition}, $flood + 1, 'and those of the flood wait on';
ask('slow', 'DELETE', "/v1/jobs/$_") for @held;
is finish('alice', $beside)->{status}, 'successful', 'it runs';

# --- what is told ---------------------------------------------------------------------------------

write_keys($file, $lines[1], "carol:submit\n");
kill 'HUP', $daemon->{pid};
ok wait_until(sub { $daemon->log_text =~ /the keys cannot be read[^\n]*line 2/ }), 'a wrong file is told of, with its line';
is ask('bob', 'GET', '/v1/jobs')->{status}, 200, 'and the keys of before hold';
write_keys($file, $lines[1]);
kill 'HUP', $daemon->{pid};
ok wait_until(sub { ask('bob', 'GET', '/v1/jobs')->{status} == 401 }), 'a key that was taken out is none any more';
is ask('alice', 'GET', '/v1/jobs')->{status}, 200, 'the others stay';
is ask('alice', 'DELETE', "/v1/jobs/$job")->{status}, 200, 'a job is removed by its own key';

my $log = $daemon->log_text;
like $log, qr/"msg":"request"[^\n]*"path":"\/v1\/jobs","client":"127\.0\.0\.1","tenant":"alice"/, 'the log says who asked';
like $log, qr/"msg":"job accepted","job":"\Q$of_bob\E","tenant":"bob"/, 'and whose job it is';
is_deeply [grep { $log =~ /\Q$key{$_}\E/ } sort keys %key], [], 'it has no key';
unlike $log, qr/\Q$ticket\E|vor_nothing/, 'and no ticket, nor what was no key';
is $daemon->stop, 0, 'the daemon ends with 0';

# --- who else may call ----------------------------------------------------------------------------

my @no = (['--listen', '0.0.0.0:0'], ['--trusted-proxy', '127.0.0.1'], ['--public-url', 'https://cloud.example']);
for my $case (@no) {
    my ($status, $text) = Vt::run('--data', "$dir/none", @$case);
    is $status, 2, "@$case without keys does not start";
    like $text, qr/\Q@$case\E the daemon is open to other machines: give --api-keys FILE .*--no-auth to allow requests without a key$/, 'and says how';
}
my ($status, $text) = Vt::run('--data', "$dir/none", '--no-auth', '--api-keys', $file);
is $status, 2, 'keys and --no-auth are at odds';
like $text, qr/--no-auth and --api-keys \Q$file\E contradict each other/, 'which is said';
($status, $text) = Vt::run('--data', "$dir/none", '--listen', '127.0.0.1:0', '--api-keys', "$dir/none");
is $status, 1, 'a file of keys that is not there ends it';
like $text, qr{^voronoid: \Q$dir/none\E: No such file}, 'and is named';
my $wide = Vt->start(listen => '0.0.0.0:0', 'api-keys' => $file);
is $wide->get('/v1/jobs')->{status}, 401, 'with keys it may listen anywhere, and asks for one';
is $wide->get('/v1/jobs', headers => { 'X-API-Key' => $key{alice} })->{status}, 200, 'which does';
$wide->stop;
my $proxied = Vt->start('trusted-proxy' => '127.0.0.1', 'api-keys' => $file);
is $proxied->get('/v1/jobs')->{status}, 401, 'behind a proxy this machine is no exception';
$proxied->stop;

# --- pages of others ------------------------------------------------------------------------------

my $plain = Vt->start('cors-origin' => 'https://app.example');
sub page { return $plain->request($_[0], '/v1/jobs', headers => { @_[1 .. $#_] })->{status} }
is page('GET', Origin => 'https://evil.example'), 403, 'a page of another origin may not even read';
is page('OPTIONS', Origin => 'https://evil.example'), 403, 'nor ask whether it may';
is page('GET', 'Sec-Fetch-Site' => 'cross-site', 'Sec-Fetch-Mode' => 'no-cors'), 403, 'nor embed what is here';
is page('GET', 'Sec-Fetch-Site' => 'cross-site', 'Sec-Fetch-Mode' => 'navigate'), 200, 'but may have a link';
is page('GET', 'Sec-Fetch-Site' => 'cross-site', Origin => 'https://app.example'), 200, 'pages that are named may';
my $preflight = $plain->request('OPTIONS', '/v1/jobs', headers => { Origin => 'https://app.example' });
like $preflight->{headers}{'access-control-allow-headers'}, qr/\bAuthorization\b.*\bX-API-Key\b/, 'and send keys';
like $preflight->{headers}{'access-control-expose-headers'}, qr/\b$_\b/, "and see $_"
    for qw(Location ETag Retry-After Content-Range X-Request-Id);
unlike $preflight->{headers}{'access-control-expose-headers'}, qr/Upload|Tus/, 'none that is never sent';
ok !exists $preflight->{headers}{'access-control-allow-credentials'}, 'without cookies';
is $plain->stop, 0, 'the daemon ends with 0';
done_testing;
