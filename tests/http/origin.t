#!/usr/bin/perl
# The frame of a Draco result over HTTP: header, statusInfo and report tell its origin, also after a restart, and pages
# may see it; what float32 is too coarse for is refused when it is submitted, or else by the job.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

# n points of a bumpy square of 100 with its corner at x, y, 0.
sub sheet {
    my ($n, $x, $y) = @_;
    my $bytes = "ply\nformat binary_little_endian 1.0\nelement vertex $n\n"
        . "property double x\nproperty double y\nproperty double z\nend_header\n";
    for my $i (0 .. $n - 1) {
        my ($u, $v) = (100 * ($i + 0.5) / $n, 100 * ($i * 0.6180339887498949 - int $i * 0.6180339887498949));
        $bytes .= pack 'd<3', $x + $u, $y + $v, sin($u / 20) + cos($v / 30);
    }
    return $bytes;
}

my $daemon = Vt->start('cors-origin' => 'https://a.example');
my $far = sheet(4000, 566000, 5933000);
my $quick = 'iterations=1&polish=0';

my $answer = $daemon->post("/v1/resample?points=300&$quick&format=drc", $far);
is $answer->{status}, 200, 'a call is answered with a Draco file';
is $answer->{headers}{'voronoid-origin'}, '566050,5933050,0', 'whose header tells its origin';
my $draco = $answer->{content};

my $id = $daemon->submit("points=300&$quick&format=drc", $far);
my $origin = { x => 566050, y => 5933050, z => 0 };
is_deeply $daemon->finish($id)->{voronoid}{origin}, $origin, 'statusInfo tells it';
is_deeply json($daemon->get("/v1/jobs/$id/results/report"))->{origin}, $origin, 'so does the report';
for my $method ('GET', 'HEAD') {
    my $result = $daemon->request($method, "/v1/jobs/$id/results/cloud", headers => { Origin => 'https://a.example' });
    is $result->{status}, 200, "$method answers";
    is $result->{headers}{'voronoid-origin'}, '566050,5933050,0', "$method tells the origin";
    like $result->{headers}{'access-control-expose-headers'}, qr/\bVoronoid-Origin\b/, "$method shows it to pages";
}
my $part = $daemon->get("/v1/jobs/$id/results/cloud", headers => { Range => 'bytes=0-9' });
is_deeply [$part->{status}, $part->{headers}{'voronoid-origin'}], [206, '566050,5933050,0'], 'a part tells it too';
is $daemon->get("/v1/jobs/$id/results/report")->{headers}{'voronoid-origin'}, undef, 'a report has no such header';

# What was a Draco file comes back to the input's coordinates.
$answer = $daemon->post("/v1/resample?points=200&$quick&format=ply", $draco);
is $answer->{headers}{'voronoid-origin'}, undef, 'PLY has no origin';
my ($body) = $answer->{content} =~ /end_header\n(.*)\z/s;
my @xyz = unpack 'd<*', $body;
sub lies { my ($x, $low) = @_; return $x > $low - 10 && $x < $low + 110 }
is scalar(grep { lies($xyz[3 * $_], 566000) && lies($xyz[3 * $_ + 1], 5933000) && lies($xyz[3 * $_ + 2], 0) } 0 .. 199), 200,
    'it lies where the input lay';
my $plain = $daemon->submit("points=200&$quick", $far);
my $info = $daemon->finish($plain);
ok !exists $info->{voronoid}{origin}, 'the statusInfo of a PLY result has none';
is_deeply json($daemon->get("/v1/jobs/$plain/results/report"))->{origin}, { x => 0, y => 0, z => 0 }, 'and its report has 0';

# A result in another format has the frame of that format.
for my $case (['drc', $plain, '566050,5933050,0'], ['ply', $id, undef]) {
    my ($format, $job, $wanted) = @$case;
    for my $times ('made', 'kept', 'HEAD') {
        my $result = $daemon->request($times eq 'HEAD' ? 'HEAD' : 'GET', "/v1/jobs/$job/results/cloud?format=$format");
        is "$result->{status} " . ($result->{headers}{'voronoid-origin'} // ''), '200 ' . ($wanted // ''),
            "a result as $format that is $times: its origin";
    }
    is $daemon->get("/v1/jobs/$job/results/cloud")->{headers}{'voronoid-origin'}, $wanted ? undef : '566050,5933050,0',
        'which is not that of the job';
}
my $farther = sheet(4000, 566000, 593300000);
my $named = $daemon->submit("points=100&$quick&origin=absolute", $farther);
is $daemon->finish($named)->{status}, 'successful', 'to PLY every origin is the same';
is_problem($daemon->get("/v1/jobs/$named/results/cloud?format=drc"), 422, 'frame-too-coarse',
    'to Draco, asked for later, it may be too coarse');

# So has a cloud that is converted.
$answer = $daemon->post('/v1/convert?format=drc', $far);
is_deeply [$answer->{status}, $answer->{headers}{'voronoid-origin'}], [200, '566050,5933050,0'], 'convert has an origin too';
$answer = $daemon->post('/v1/convert?format=drc&origin=566000,5933000,0', $far);
is $answer->{headers}{'voronoid-origin'}, '566000,5933000,0', 'also one that is asked for';
for my $bits ('auto', 16) {
    is_problem($daemon->post("/v1/convert?format=drc&origin=absolute&quantization=$bits", $farther), 422, 'frame-too-coarse',
        "convert refuses one that is too coarse, quantization=$bits");
}

# A cloud near 0 is written as it is, whatever its type.
$answer = $daemon->post("/v1/resample?points=300&$quick&format=drc", sheet(4000, 10, 20));
is $answer->{headers}{'voronoid-origin'}, '0,0,0', 'a cloud near 0 is absolute';
$answer = $daemon->post("/v1/resample?points=300&$quick&format=drc&origin=1,-2.5,3", sheet(4000, 10, 20));
is $answer->{headers}{'voronoid-origin'}, '1,-2.5,3', 'unless another origin is asked for';

# Steps of 0.5 at 5933100: 3000 points are 1.9 apart, 300 are 6.2.
for my $prefer ('respond-async', 'wait=30') {
    $answer = $daemon->post("/v1/resample?points=3000&$quick&format=drc&origin=absolute", $far, Prefer => $prefer);
    is_problem $answer, 422, 'frame-too-coarse', "absolute is refused when it is submitted ($prefer)";
    like json($answer)->{detail}, qr/float32 has steps of 0\.5 /, 'with the step';
    is json($answer)->{errors}[0]{parameter}, 'origin', 'and the parameter';
}
$id = $daemon->submit("points=300&$quick&format=drc&origin=absolute", $far);
$info = $daemon->finish($id);
is $info->{status}, 'failed', 'where only the result tells, the job fails';
is_problem $daemon->get("/v1/jobs/$id/results/cloud"), 422, 'frame-too-coarse', 'with the same problem';
$answer = $daemon->post("/v1/resample?points=300&$quick&format=ply&origin=absolute", $far);
is $answer->{status}, 200, 'PLY is never too coarse';
is_problem $daemon->post("/v1/resample?points=300&format=drc&origin=1,2", $far), 400, 'invalid-parameter',
    'two numbers are no origin';

# A job keeps it over a restart.
$id = $daemon->submit("points=300&$quick&format=drc", $far);
$daemon->finish($id);
is $daemon->stop, 0, 'the daemon ends';
$daemon = Vt->start(dir => $daemon->{dir});
is_deeply json($daemon->get("/v1/jobs/$id"))->{voronoid}{origin}, $origin, 'after a restart statusInfo tells it';
is $daemon->get("/v1/jobs/$id/results/cloud")->{headers}{'voronoid-origin'}, '566050,5933050,0', 'and so does the header';
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
