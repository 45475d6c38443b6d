#!/usr/bin/perl
# Jobs as forms (multipart/form-data), as curl -F and browsers send them: fields are parameters, files are inputs by
# name. And JSON, which is told where its parameters belong.
use strict;
use warnings;
use FindBin;
use File::Temp qw(tempdir);
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $dir = tempdir(CLEANUP => 1);
my $daemon = Vt->start('body-limit' => '8M', dir => tempdir(CLEANUP => 1));
my $cloud = sphere_ply(500);
my $brief = 'iterations=2&polish=0';
my @brief = ('-F', 'iterations=2', '-F', 'polish=0');

sub file {
    my ($name, $bytes) = @_;
    spew("$dir/$name", $bytes);
    return "$dir/$name";
}

# curl with these arguments: the answer in HTTP::Tiny's shape.
sub curl {
    my ($path, @arguments) = @_;
    my $status = do {
        open my $out, '-|', 'curl', '-s', '-m', 60, '-D', "$dir/head", '-o', "$dir/body", '-w', '%{http_code}', @arguments,
            "$daemon->{url}$path" or die;
        local $/;
        <$out>;
    };
    my ($last) = Vt::slurp("$dir/head") =~ /(HTTP\/1\.1 (?!100).*)\z/s;
    my %headers = map { /^([^:]+): (.*)$/ ? (lc $1 => $2) : () } split /\r\n/, $last // '';
    return { status => $status, headers => \%headers, content => Vt::slurp("$dir/body") };
}

# A form written by hand: parts are [disposition and more header lines, bytes].
sub form {
    my ($path, $parts, %more) = @_;
    my $body = join('', map { "--bnd\r\nContent-Disposition: form-data; $_->[0]\r\n\r\n$_->[1]\r\n" } @$parts) . "--bnd--\r\n";
    return $daemon->post($path, $more{body} // $body, 'Content-Type' => $more{type} // 'multipart/form-data; boundary=bnd',
        %{ $more{headers} // {} });
}

my $ply = file('x.ply', $cloud);
my $raw = $daemon->post("/v1/resample?points=100&$brief", $cloud);
is $raw->{status}, 200, 'a raw body is served' or diag $raw->{content};

# What curl sends.
for my $case (
    ['the file first', '-F', "file=\@$ply", '-F', 'points=100', @brief],
    ['the file last', '-F', 'points=100', @brief, '-F', "file=\@$ply"],
    ['the file in between', '-F', 'points=100', '-F', "cloud=\@$ply", @brief],
    ['the file without its name', '-F', "cloud=<$ply", '-F', 'points=100', @brief],
    ['in chunks', '-H', 'Transfer-Encoding: chunked', '-F', "file=\@$ply", '-F', 'points=100', @brief],
    ['after a question', '-H', 'Expect: 100-continue', '-F', "file=\@$ply", '-F', 'points=100', @brief],
) {
    my ($name, @arguments) = @$case;
    my $answer = curl('/v1/resample', @arguments);
    is $answer->{status}, 200, "a form with $name is served" or diag $answer->{content};
    ok $answer->{content} eq $raw->{content}, 'with the bytes that a raw body gets';
}
my $long = curl('/v1/processes/resample/execution', '-F', "file=\@$ply", '-F', 'points=100', @brief);
ok $long->{content} eq $raw->{content}, 'so it is at the execution of the process';
my $half = curl("/v1/resample?points=100&iterations=2", '-F', "file=\@$ply", '-F', 'polish=0');
ok $half->{content} eq $raw->{content}, 'and with some parameters in the query';
my $drc = curl('/v1/resample', '-F', 'format=drc', '-F', "file=\@$ply", '-F', 'points=100', @brief);
is $drc->{headers}{'content-type'}, 'application/draco', 'a field chooses the format';
my $async = curl('/v1/resample', '-H', 'Prefer: respond-async', '-F', "file=\@$ply", '-F', 'points=100', @brief);
is $async->{status}, 201, 'a job is accepted';
is $daemon->finish(json($async)->{jobID})->{status}, 'successful', 'and ends well';
like curl('/v1/resample', '-H', 'Accept: text/event-stream', '-F', "file=\@$ply", '-F', 'points=100', @brief)->{content},
    qr/^event: end\ndata: \{.*"status":"successful"/m, 'or is followed as a stream';
is_problem(curl('/v1/resample', '-H', 'Accept: image/png', '-F', "file=\@$ply", '-F', 'points=100'), 406, 'not-acceptable',
    'an Accept that cannot be met');

# Two inputs.
my $other = file('y.ply', sphere_ply(400));
my $both = curl('/v1/measure', '-F', "reference=\@$other", '-F', "cloud=\@$ply");
is $both->{status}, 200, 'measure takes a cloud and a reference' or diag $both->{content};
is $both->{headers}{'content-type'}, 'application/json', 'and answers with its document';
is_deeply json($both), json(scalar qx($ENV{VORONOID} measure $ply --reference=$other --json)), 'the one of the command line';
my $alone = curl('/v1/measure', '-F', "file=\@$ply");
is_deeply json($alone), json($daemon->post('/v1/measure', $cloud)), 'a cloud alone is the same as a raw body';
is json($both)->{n}, 500, 'the reference is not taken for the cloud';
my $empty = form('/v1/measure', [['name="cloud"; filename="x.ply"', $cloud], ['name="reference"; filename=""', '']]);
is_deeply json($empty), json($alone), "a browser's field without a file is none";
my $id = (split m{/}, $both->{headers}{location})[-1];
my $info = json($daemon->get("/v1/jobs/$id"));
is $info->{processID}, 'measure', 'there is a job of it';
is_deeply { map { $_ => $info->{voronoid}{inputs}{$_}{points} } keys %{ $info->{voronoid}{inputs} } }, { cloud => 500, reference => 400 },
    'which tells its inputs';
is_deeply json($daemon->get("/v1/jobs/$id/results/measure")), json($both), 'with its result';
refused(curl('/v1/measure', '-F', "reference=\@$ply"), 400, 'invalid-parameter', qr/^measure needs a cloud, but the request has none$/,
    'a reference without a cloud');
refused(curl('/v1/measure?peak=1', '-F', "cloud=\@$ply"), 400, 'invalid-parameter', qr/^the parameter peak is 1, which needs a reference cloud, but the request has none$/,
    'a peak without a reference');
my $rubbish = file('z.ply', 'rubbish');
refused(curl('/v1/measure', '-F', "cloud=\@$ply", '-F', "reference=\@$rubbish"), 415, 'unsupported-format',
    qr/^reference: the input begins with "rubbish"/, 'of two files the one at fault is named');

# Refusals.
my @cloud = ('name="cloud"; filename="x.ply"', $cloud);
my @points = ('name="points"', 100);
for my $case (
    ['both in query and form', '?points=100', [[@cloud], [@points]], 400, qr/^points is given in the query and in the form/],
    ['a field twice', '', [[@points], [@points], [@cloud]], 400, qr/^points is given more than once$/],
    ['a file twice', '', [[@points], [@cloud], ['name="file"; filename="y"', $cloud]], 400, qr/^cloud is given more than once$/],
    ['an unknown field', '', [[@points], ['name="pionts"', 5], [@cloud]], 400,
        qr/^unknown parameter "pionts" of resample; nearest: points, [\w, ]+; its files are cloud \(or file\), previous$/],
    ['an unknown file', '', [[@points], ['name="mesh"; filename="x"', 'y' x 9999], [@cloud]], 400,
        qr/^unknown parameter "mesh" of resample; nearest: .*; its files are cloud \(or file\), previous$/],
    ["another process's file", '', [[@points], ['name="reference"; filename="x"', 'y'], [@cloud]], 400, qr/^unknown parameter "reference" of /],
    ['a parameter as a file', '', [['name="points"; filename="points.txt"', 100], [@cloud]], 400, qr/^points is a file, want a text$/],
    ['a value out of range', '', [['name="points"', 0], [@cloud]], 400, qr/^points is 0, want a whole number from 1 to 10000000$/],
    ['a text with a NUL', '', [['name="points"', "100\0"], [@cloud]], 400, qr/^points has a NUL byte, want a text without one$/],
    ['a text of 4097 bytes', '', [['name="points"', '1' x 4097], [@cloud]], 400, qr/^points has more than the allowed 4096 bytes/],
    ['a text of 4096 bytes', '', [['name="points"', '1' x 4096], [@cloud]], 400, qr/^points is 1+/],
    ['no points', '', [[@cloud]], 400, qr/^give exactly one of the parameters points, ratio and spacing: none/],
    ['no file', '', [[@points]], 400, qr/^resample needs a cloud, but the request has none$/],
    ['no part', '', [], 400, qr/^resample needs a cloud, but the request has none$/],
) {
    my ($name, $query, $parts, $status, $detail) = @$case;
    my $answer = form("/v1/resample$query", $parts);
    refused($answer, $status, 'invalid-parameter', $detail, $name);
    ok json($answer)->{errors}[0]{parameter}, "$name: errors[] names it";
}
is form('/v1/resample', [[@points], [@cloud]])->{status}, 200, 'the same connection serves on';
for my $case (
    ['33 parts', [map { ["name=\"x$_\"; filename=\"\"", ''] } 1 .. 33], {}, qr/^unknown parameter "x1" of /, 'invalid-parameter'],
    ['a part without a name', [['filename="x"', 1]], {}, qr/^the form is malformed: a part has no Content-Disposition with a name$/],
    ['a body that is none', [], { body => $cloud }, qr/^the form is malformed: it does not begin with -- and the boundary, got "p"$/],
    ['an empty body', [], { body => '' }, qr/^the form is malformed: it ends without a last boundary/],
    ['a form cut short', [], { body => "--bnd\r\nContent-Disposition: form-data; name=cloud\r\n\r\n$cloud" }, qr/it ends without a last boundary/],
    ['no boundary', [[@cloud]], { type => 'multipart/form-data' }, qr/^Content-Type has no boundary, want a boundary of 1 to 70/],
    ['a boundary of 71', [[@cloud]], { type => 'multipart/form-data; boundary=' . 'b' x 71 }, qr/of 71 characters is invalid/],
) {
    my ($name, $parts, $more, $detail, $slug) = @$case;
    refused(form('/v1/resample?points=100', $parts, %$more), 400, $slug // 'malformed-request', $detail, $name);
}
my @same = map { ['name="reference"; filename=""', ''] } 1 .. 32;
is form('/v1/measure', [@same[0 .. 30], [@cloud]])->{status}, 200, '32 parts are allowed';
refused(form('/v1/measure', [@same, [@cloud]]), 400, 'malformed-request', qr/more than 32 parts/, '33 are not');
my $b70 = 'b' x 70;
is form('/v1/resample?points=100', [], type => "multipart/form-data; boundary=$b70",
    body => "--$b70\r\nContent-Disposition: form-data; name=file\r\n\r\n$cloud\r\n--$b70--\r\n")->{status}, 200, 'a boundary of 70 is';
refused(form('/v1/resample', [[@points], [@cloud]], headers => { 'Content-Encoding' => 'gzip' }), 415, 'unsupported-format',
    qr/gzip for the whole form, want it only in the headers of a part/, 'a form that is gzip as a whole');
my $large = file('large.ply', 'x' x 3_000_000);
refused(curl('/v1/resample', '-F', 'pionts=5', '-F', "file=\@$large"), 400, 'invalid-parameter', qr/^unknown parameter "pionts" of /,
    'a long form that is refused at its beginning');
refused(curl('/v1/resample', '-F', 'points=5', '-F', "file=\@$large", '-F', "cloud=\@$large", '-F', "cloud=\@$large"), 413,
    'too-many-bytes', qr/want at most 8388608/, 'a form beyond the limit of bodies');

# The name of a file leads nowhere.
for my $name ('../../../../tmp/vt-escape', '/tmp/vt-escape', 'a";\\"b', "x\xff\xfe", '%0d%0aX-Evil: 1', 'x' x 2000, '\\\\host\\x', '..') {
    my $answer = form('/v1/resample?points=100', [["name=\"file\"; filename=\"" . ($name =~ s/(["\\])/\\$1/gr) . '"', $cloud]]);
    is $answer->{status}, 200, 'a file of any name is served' or diag $answer->{content};
    unlike join("\n", %{ $answer->{headers} }), qr/evil|escape|passwd|x\xff|xxxx/i, 'and no header has it';
}
ok !-e '/tmp/vt-escape', 'no file has it either';
is join(' ', sort map { s{.*/}{}r } glob "$daemon->{dir}/data/*"), 'blobs jobs.sqlite jobs.sqlite-shm jobs.sqlite-wal jobs.sqlite.lock jobs.sqlite.reserve', 'nor anything beside our own';
is scalar(() = glob "$daemon->{dir}/data/blobs/tmp/*"), 0, 'nothing is left half-way';

# Pages of other sites.
my @form = ('-F', "file=\@$ply", '-F', 'points=100', @brief);
is curl('/v1/resample', '-H', "Sec-Fetch-Site: $_", @form)->{status}, 200, "a form of a page that is $_ is served"
    for qw(same-origin same-site none);
is curl('/v1/resample', '-H', "Origin: $daemon->{url}", '-H', 'Sec-Fetch-Site: same-origin', @form)->{status}, 200, 'one of our own';
is_problem(curl('/v1/resample', '-H', 'Sec-Fetch-Site: cross-site', @form), 403, 'forbidden', 'one of another site is refused');
is_problem(curl('/v1/resample', '-H', "Origin: $_", @form), 403, 'forbidden', "one of $_ is refused") for 'https://evil.example', 'null';
is $daemon->get('/livez', headers => { 'Sec-Fetch-Site' => 'cross-site', 'Sec-Fetch-Mode' => 'navigate' })->{status}, 200,
    'who only follows a link is not';
{
    my $cors = Vt->start('cors-origin' => 'https://app.example');
    my ($was, @there) = ($daemon, '-H', 'Sec-Fetch-Site: cross-site', @form);
    $daemon = $cors;
    is curl('/v1/resample', '-H', 'Origin: https://app.example', @there)->{status}, 200, 'a page of --cors-origin is served';
    is_problem(curl('/v1/resample', '-H', "Origin: $_", @there), 403, 'forbidden', "and none of $_")
        for 'https://evil.example', $cors->{url};
    like $cors->request('OPTIONS', '/v1/resample', headers => { Origin => 'https://app.example' })
        ->{headers}{'access-control-allow-headers'}, qr/\bContent-Encoding\b/, 'which may say how a body is coded';
    $cors->stop;
    $daemon = $was;
}

# JSON.
my %json = ('Content-Type' => 'application/json');
my $told = $daemon->post('/v1/processes/resample/execution',
    '{"inputs":{"points":1000,"filters":["mls"],"format":"drc","cloud":{"href":"x"}},"seed":2,"response":"raw"}', %json);
refused($told, 400, 'invalid-parameter',
    qr{^points is in a JSON body, at /inputs/points; parameters belong in the query, .*: POST /v1/resample\?points=1000&filters=\.\.\.&format=drc&seed=2;},
    'parameters in JSON');
is_deeply [map { $_->{pointer} } @{ json($told)->{errors} }], [qw(/inputs/points /inputs/filters /inputs/format /seed)],
    'errors[] has the place of each';
for my $case (
    ['{"points":5}', 400, 'invalid-parameter', qr{^points is in a JSON body, at /points;}],
    ['{}', 415, 'unsupported-format', qr/^the body is JSON, want a cloud, or a form/],
    ['[1,2]', 415, 'unsupported-format', qr/^the body is JSON/],
    ['{"mesh":{"points":{"points":3}}}', 400, 'invalid-parameter', qr{at /mesh/points;}],
    ['{"points":5', 400, 'malformed-request', qr/./],
    ['{"points":5,"points":6}', 400, 'invalid-parameter', qr{points=5&points=6;}],
    [' ', 400, 'malformed-request', qr/./],
    ['', 400, 'invalid-parameter', qr/^give exactly one of the parameters points, ratio and spacing: none/],
    ['{"a":"' . 'x' x (1 << 20) . '"}', 413, 'too-many-bytes', qr/want at most 1048576/],
) {
    my ($body, $status, $slug, $detail) = @$case;
    refused($daemon->post('/v1/resample', $body, %json), $status, $slug, $detail, 'JSON ' . substr $body, 0, 30);
}
is_problem($daemon->post('/v1/resample?points=3', '{"points":5}', 'Content-Type' => 'application/geo+json; charset=utf-8'), 400,
    'invalid-parameter', 'JSON of another kind');
is_problem($daemon->post('/v1/processes/nope/execution', '{}', %json), 404, 'no-such-process', 'JSON for a process that is not');
is scalar(grep { $_->{status} && $_->{status} =~ /^5/ } $daemon->log_lines), 0, 'nothing was our own fault';
is $daemon->stop, 0, 'it ends with 0';
done_testing;
