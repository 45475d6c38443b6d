#!/usr/bin/perl
# Formats over HTTP: the process convert, results in another format than the job's, what Accept and the query of a result
# may say, points that are not finite, and what a result does not have of its input.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $daemon = Vt->start;
my $points = 600;
my $cloud = sphere_ply($points);
my $signature = "comment written by voronoid\n";

sub job_of { return $_[0]{headers}{location} =~ m{(/v1/jobs/[^/]+)\z} ? $1 : die 'no Location' }
sub report_of { return json($daemon->get(job_of($_[0]) . '/results/report')) }
sub kept { return grep { /-as-/ } $daemon->blobs }

# --- the process ----------------------------------------------------------------------------------

my $remarks = "comment a scan of \xe4\nobj_info num_cols 3\ncomment\ttwo\n";
my $rich = "ply\nformat ascii 1.0\n${remarks}element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    . "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float label\nelement face 2\n"
    . "property list uchar int vertex_indices\nend_header\n0 0 0 1 2 3 0.5\n1 0 0 4 5 6 0.25\n0 1 0 7 8 9 1\n0 0 1 10 11 12 2\n"
    . "3 0 1 2\n3 0 2 3\n";
my @rows = ([0, 0, 0, 1, 2, 3, 0.5], [1, 0, 0, 4, 5, 6, 0.25], [0, 1, 0, 7, 8, 9, 1], [0, 0, 1, 10, 11, 12, 2]);
my $plain = "ply\nformat binary_little_endian 1.0\n${signature}${remarks}element vertex 4\nproperty float x\nproperty float y\n"
    . "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float label\nelement face 2\n"
    . "property list uchar int vertex_indices\nend_header\n" . join('', map { pack 'f<3C3f<', @$_ } @rows);
my $faces = pack '(Cl<3)2', 3, 0, 1, 2, 3, 0, 2, 3;

my $same = $daemon->post('/v1/convert', $rich);
is $same->{status}, 200, 'PLY is converted to PLY' or diag($same->{content});
is $same->{content}, $plain . $faces, 'with its points, attributes, faces, comments and obj_info';
my $report = report_of($same);
is_deeply $report->{points}, { in => 4, out => 4 }, 'the report counts the points';
is_deeply [@$report{qw(faces dropped)}], [2, []], 'and faces, and nothing is left out';
is $report->{delta}, undef, 'and claims no delta';
is $report->{invalid}, 0, 'and no point was invalid';
is json($daemon->get(job_of($same)))->{message}, '4 points', 'the job says how many';

my $draco = $daemon->post('/v1/convert?format=drc&quantization=0', $rich);
is $draco->{headers}{'content-type'}, 'application/draco', 'PLY is converted to Draco';
is_deeply report_of($draco)->{dropped},
    [{ what => 'comment', count => 2 }, { what => 'obj_info', count => 1 }], 'which has no comments';
my $back = $daemon->post('/v1/convert', $draco->{content}, Accept => 'application/ply');
my $size = 4 * length pack 'f<3C3f<', @{ $rows[0] };
my ($came, $went) = map { [substr($_, 0, -$size), sort unpack '(a19)4', substr $_, -$size] } substr($back->{content}, 0, -length $faces),
    $plain =~ s/\Q$remarks\E//r;
is_deeply $came, $went, 'and back, bit for bit, in the order of a Draco mesh';
is_deeply report_of($back)->{dropped}, [], 'nothing is left out on that way';
my $restored = $daemon->post('/v1/restore', $rich);
is $restored->{content}, $plain . $faces, 'restore keeps points, attributes, faces and comments where it finds no lattice';
is_deeply [map { @$_{qw(about value limit)} } @{ report_of($restored)->{warnings} }], ['lattice', 0, 4], 'and says so';
is report_of($daemon->post('/v1/convert?format=drc', $cloud))->{parameters}{quantization}, 'auto', 'auto is said';
my $spacing = json($daemon->post('/v1/inspect', $cloud))->{spacing}{mean};
cmp_ok abs(report_of($daemon->post('/v1/convert?format=drc', $cloud))->{spacing} / $spacing - 1), '<', 1e-5,
    'and follows the spacing that it finds';
my $one = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n";
is $daemon->post("/v1/convert?format=$_", $one)->{status}, 200, "a single point becomes $_" for qw(ply drc);
is_problem($daemon->post('/v1/convert?points=5', $cloud), 400, 'invalid-parameter', 'it takes no number of points');

# A comment in a resampling is kept as well.
my $said = $cloud =~ s/element vertex/comment kept\ncomment written by voronoid\nelement vertex/r;
like $daemon->post('/v1/resample?points=60&iterations=1&polish=0', $said)->{content},
    qr/\Aply\nformat binary_little_endian 1.0\n${signature}comment kept\nelement vertex 60\n/, 'a resampled cloud has the comments';

# So is what a request drops.
my $dense = $cloud =~ s/(property float z\n)/$1property uchar heat\n/r;
my $from = index($dense, "end_header\n") + 11;
substr($dense, $from) = join '', map { substr($cloud, index($cloud, "end_header\n") + 11 + 12 * $_, 12) . chr($_ % 256) }
    0 .. $points - 1;
is_deeply report_of($daemon->post('/v1/resample?points=60&iterations=1&polish=0' . $_->[0], $dense))->{dropped}, $_->[1],
    "what is dropped is said ($_->[0])" for ['', []], ['&attributes=drop', [{ what => 'attribute heat', count => $points }]];

# --- points that are not finite -------------------------------------------------------------------

my $holes = $cloud =~ s/element vertex \d+/'element vertex ' . ($points + 3)/er;
$holes .= pack('f<3', 1, 'nan', 0) . pack('f<3', 'inf', 0, 0) . pack('f<3', 0, 0, '-inf');
for my $process ('resample?points=60&iterations=1&polish=0', 'convert?') {
    my $refused = $daemon->post("/v1/$process", $holes);
    is_problem($refused, 422, 'non-finite-points', "$process refuses them");
    is json($refused)->{detail},
        '3 of 603 points have a coordinate that is not finite. The first is point 600: its y is nan. invalid=drop leaves such points out',
        'and says how many, and what would drop them';
    is json($refused)->{errors}[0]{parameter}, 'invalid', 'also for programs';
    my $taken = $daemon->post("/v1/$process&invalid=drop", $holes);
    is $taken->{status}, 200, 'which it does';
    is report_of($taken)->{invalid}, 3, 'and counts them';
    is $taken->{content}, $daemon->post("/v1/$process", $cloud)->{content}, 'the result is that of the others';
}
is json($daemon->post('/v1/inspect?invalid=drop', $holes))->{points}{invalid}, 3, 'inspect counts them too';
my $of_job = 'input=job:' . (job_of($daemon->post('/v1/convert?invalid=drop', $holes)) =~ s{.*/}{}r);
is_problem($daemon->post("/v1/convert?$of_job", ''), 422, 'non-finite-points', 'the input of a job is kept with them');
is report_of($daemon->post("/v1/convert?$of_job&invalid=drop", ''))->{invalid}, 3, 'and they are dropped again where asked for';
is report_of($daemon->post("/v1/convert?$of_job&invalid=drop&format=drc", ''))->{invalid}, 3, 'in any format';
is_problem($daemon->post('/v1/convert?invalid=keep', $holes), 400, 'invalid-parameter', 'there is no other word');

# --- a result in another format -------------------------------------------------------------------

my $query = 'points=300&iterations=2&polish=0&seed=5';
my %direct = map { $_ => $daemon->post("/v1/resample?$query&format=$_", $cloud) } qw(ply drc);
for my $case ([drc => 'ply', 'application/ply'], [ply => 'drc', 'application/draco']) {
    my ($is, $wanted, $type) = @$case;
    my $path = job_of($direct{$is}) . '/results/cloud';
    my $head = $daemon->request('HEAD', "$path?format=$wanted");
    is "$head->{status} $head->{headers}{'content-type'}", "200 $type", "HEAD of a $is as $wanted says what it is";
    ok !defined $head->{headers}{etag} && !$head->{headers}{'content-length'}, 'and has nothing made';
    is scalar(() = kept()), ($is eq 'drc' ? 0 : 1), 'nor kept';
    my $got = $daemon->get("$path?format=$wanted");
    is "$got->{status} $got->{headers}{'content-type'}", "200 $type", 'GET has it made' or diag($got->{content});
    is $got->{headers}{etag}, '"' . sha256_hex($got->{content}) . '"', 'with the SHA-256 of its bytes for an ETag';
    isnt $got->{headers}{etag}, $direct{$is}{headers}{etag}, 'of its own';
    like $got->{headers}{'content-disposition'}, qr/\.$wanted"\z/, 'and a name with its suffix';
    is scalar(() = kept()), ($is eq 'drc' ? 1 : 2), 'and it is kept';
    my $again = $daemon->get("$path?format=$wanted");
    is $again->{content}, $got->{content}, 'the next one gets the same';
    $head = $daemon->request('HEAD', "$path?format=$wanted");
    is "$head->{headers}{etag} $head->{headers}{'content-length'}", "$got->{headers}{etag} " . length $got->{content},
        'now HEAD tells ETag and length';
    my $part = $daemon->get("$path?format=$wanted", headers => { Range => 'bytes=3-9' });
    is "$part->{status} $part->{content}", '206 ' . substr($got->{content}, 3, 7), 'it has ranges';
    is $daemon->get("$path?format=$wanted", headers => { 'If-None-Match' => $got->{headers}{etag} })->{status}, 304,
        'and is told apart';
    is $daemon->get("$path?format=$is")->{content}, $direct{$is}{content}, 'its own format is the result itself';
}
is $daemon->get(job_of($direct{ply}) . '/results/cloud?format=drc')->{content}, $direct{drc}{content},
    'a PLY result as Draco is what the same request gives as Draco';
is scalar(grep { /result converted/ } map { $_->{msg} } $daemon->log_lines), 2, 'each was made once';

# --- what a result may be asked -------------------------------------------------------------------

my $results = job_of($direct{ply}) . '/results';
for my $case (["$results/cloud?format=las", qr/^format is "las", want one of ply, drc$/], ["$results/cloud?fromat=ply", qr/fromat.*want format or link$/],
    ["$results/cloud?format=ply&format=ply", qr/more than once/], ["$results/report?format=ply", qr/^unknown parameter "format"; want link$/],
    ["$results/report?link=no", qr/^link must be true or false$/],
    ["$results?format=ply", qr/^unknown parameter "format"; want none$/]) {
    my ($path, $detail) = @$case;
    my $answer = $daemon->get($path);
    is_problem($answer, 400, 'invalid-query-parameter-value', $path =~ s{^.*/results}{}r);
    like json($answer)->{detail}, $detail, 'says what is wanted';
}
for my $case (
    ["$results/cloud", 'application/draco', 406], ["$results/cloud", 'text/csv', 406], ["$results/cloud", 'model/ply', 200],
    ["$results/cloud", 'image/png, */*;q=0.1', 200], ["$results/cloud", 'application/octet-stream', 200],
    ["$results/cloud", 'application/ply;q=0, */*', 406], ["$results/cloud", 'application/*', 200],
    ["$results/cloud?format=drc", 'application/draco', 200], ["$results/cloud?format=drc", 'application/ply', 406],
    ["$results/report", 'application/ply', 406], ["$results/report", 'application/json', 200], [$results, 'text/csv', 406],
    [$results, 'application/*;q=0.5', 200]) {
    my ($path, $accept, $status) = @$case;
    my $answer = $daemon->get($path, headers => { Accept => $accept });
    if ($status == 406) { is_problem($answer, 406, 'not-acceptable', "$accept of " . ($path =~ s{^.*/results}{results}r)) }
    else { is $answer->{status}, 200, "$accept of " . ($path =~ s{^.*/results}{results}r) }
}
is_problem($daemon->post('/v1/resample?points=50&iterations=1&format=drc', $cloud, Accept => 'application/ply'), 406,
    'not-acceptable', 'a format that Accept leaves out');
is $daemon->post('/v1/resample?points=50&iterations=1&format=drc', $cloud, Accept => 'application/json',
    Prefer => 'respond-async')->{status}, 201, 'but the address of a job is JSON';

# Of one caller's conversions 64 wait for a thread, of which one is left to others; one more is told to come back. None gets
# anywhere while the process that others are forked from stands still.
my $cores = `nproc` + 0;
my $most = 64 + ($cores > 2 ? $cores - 1 : 1);
my @jobs = map { job_of($daemon->post('/v1/convert?format=ply', $one)) } 0 .. $most;
my ($zygote) = grep { Vt::slurp("/proc/$_/comm") eq "vor-zygote\n" } split ' ', Vt::slurp("/proc/$daemon->{pid}/task/$daemon->{pid}/children");
kill 'STOP', $zygote;
my %waits = map {
    my $socket = $daemon->connect;
    print $socket "GET $_/results/cloud?format=drc HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    ($_ => $socket);
} @jobs;
my ($early) = IO::Select->new(values %waits)->can_read($Vt::PATIENCE);
my ($more) = grep { $waits{$_} == ($early // 0) } @jobs;
my $refusal = defined $early ? Vt::read_all(delete $waits{$more}) : '';
like $refusal, qr{\AHTTP/1\.1 429 .*\r\nRetry-After: \d+\r\n.*/problems/too-many-conversions"}s, "of @{[$most + 1]} conversions at a time one is too many";
kill 'CONT', $zygote;
# Another one where all came before the thread took its first.
like join(' ', sort map { Vt::read_all($_) =~ m{\AHTTP/1\.1 (\d+)} } values %waits), qr/\A(200 ){@{[$most - 1]}}(200|429)\z/, 'the others wait, and are made';
is $daemon->get("$more/results/cloud?format=drc")->{status}, 200, 'as is the one that comes back';
$daemon->request('DELETE', $_) for @jobs;

# A job that goes takes its converted results along, and they outlive the daemon.
my $path = job_of($direct{drc}) . '/results/cloud?format=ply';
my $before = $daemon->get($path);
is $daemon->stop, 0, 'the daemon ends';
$daemon = Vt->start(dir => $daemon->{dir});
is $daemon->get($path)->{headers}{etag}, $before->{headers}{etag}, 'the next one has what was converted';
is scalar(grep { /result converted/ } map { $_->{msg} } $daemon->log_lines), 0, 'without making it anew';
$daemon->request('DELETE', job_of($_)) for values %direct;
is scalar(() = kept()), 0, 'a removed job leaves none behind';
is_problem($daemon->get($path), 404, 'no-such-job', 'and its result is gone');
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
