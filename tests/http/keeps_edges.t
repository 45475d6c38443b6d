#!/usr/bin/perl
# Methods ear and wlop over HTTP: the events of both phases, normals of the result, the report, and a job that is ended while points
# are inserted.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $daemon = Vt->start(jobs => 1);

# n points of a cube, each near the middle of a part of its own of a face.
sub cube_ply {
    my ($side) = @_;
    my $n = 6 * $side * $side;
    my $bytes = "ply\nformat binary_little_endian 1.0\nelement vertex $n\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    for my $i (0 .. $n - 1) {
        my ($face, $at) = (int($i / ($side * $side)), $i % ($side * $side));
        my @x = map { $_ / $side } ($at % $side) + 0.5 + 0.3 * sin($i * 12.9898), int($at / $side) + 0.5 + 0.3 * sin($i * 78.233);
        splice @x, $face % 3, 0, $face < 3 ? 0 : 1;
        $bytes .= pack 'f<3', @x;
    }
    return $bytes;
}

my $cloud = cube_ply(14);
my $id = $daemon->submit('points=3000&method=ear&samples=900', $cloud);
is $daemon->finish($id)->{status}, 'successful', 'a cube is resampled up to its edges';
my @events = $daemon->events("/v1/jobs/$id/events", headers => { 'Last-Event-ID' => '1.1' })->all;
my @told = map { json($_->{data}) } grep { $_->{event} eq 'progress' } @events;
my (%steps, @order);
for my $record (@told) {
    push @order, $record->{run_stage} unless @order && $order[-1] eq $record->{run_stage};
    push @{ $steps{ $record->{run_stage} } }, $record->{step};
}
is "@order[0, 1]", 'project insert', 'events tell of the projection, then of the insertion' or diag("@order");
cmp_ok scalar(grep { $_ > 0 } @{ $steps{$_} // [] }), '>', 0, "with steps of stage $_" for qw(project insert);
my @over = map { $_->{progress} } @told;
is scalar(grep { $over[$_] < $over[$_ - 1] } 1 .. $#over), 0, 'and a progress that never falls';

my $report = json($daemon->get("/v1/jobs/$id/results/report"));
is $report->{points}{out}, 3000, 'there are as many points as asked for';
is $report->{parameters}{$_->[0]}, $_->[1], "the report has $_->[0]" for ['method', 'ear'], ['samples', 900], ['rho', 5];
is join(' ', sort grep { /insert|project/ } map { $_->{stage} } @{ $report->{stages} }), 'insert project', 'and both phases';

sub properties { return join ' ', $_[0]{content} =~ /^property float (\w+)$/mg }
is properties($daemon->get("/v1/jobs/$id/results/cloud")), 'x y z nx ny nz', 'the points have normals';
is properties($daemon->post('/v1/resample?points=800&method=ear&normals=drop', $cloud)), 'x y z', 'unless they are dropped';

# All normals face outwards: as many points see the middle behind them as there are.
my $bytes = $daemon->get("/v1/jobs/$id/results/cloud")->{content};
my ($head, $body) = split /(?<=end_header\n)/, $bytes, 2;
my $inward = 0;
for my $row (map { [unpack 'f<6', substr $body, 24 * $_, 24] } 0 .. 2999) {
    my $out = 0;
    $out += ($row->[$_] - 0.5) * $row->[3 + $_] for 0 .. 2;
    $inward++ if $out <= 0;
}
is $inward, 0, 'and all of them face outwards';

my $wlop = $daemon->post('/v1/denoise?method=wlop', $cloud);
is $wlop->{status}, 200, 'denoise takes wlop' or diag($wlop->{content});
is $daemon->post('/v1/upsample?method=ear&ratio=2', $cloud)->{status}, 200, 'upsample takes ear';

is_problem($daemon->post('/v1/upsample?method=ear&sigmaN=0', $cloud), 400, 'invalid-parameter', 'an angle of 0')
    and like json($daemon->post('/v1/upsample?method=ear&sigmaN=0', $cloud))->{detail}, qr/^sigmaN is 0, want a number from 1 to 90$/,
    'which is named';

# What neither can do is refused by name.
for my $case (['ear', 'density=curvature', 'density=curvature does not work with method=ear: use uniform or method=cvt'],
    ['isotropic', 'boundary=sites', 'boundary=sites does not work with method=isotropic: use keep or method=cvt'],
    ['wlop', 'metric=anisotropic', 'metric=anisotropic does not work with method=wlop: use isotropic or method=cvt'],
    ['ear', 'rho=21', 'rho is 21, want a number from 0 to 20'], ['wlop', 'mu=0.5', 'mu is 0.5, want a number from 0 to 0.499']) {
    my ($method, $asked, $detail) = @$case;
    my $refused = $daemon->post("/v1/resample?points=100&method=$method&$asked", $cloud);
    is_problem($refused, 400, 'invalid-parameter', "$method with $asked") and is json($refused)->{detail}, $detail, 'which is named';
}

# What has no effect is done, and warned of.
my $still = $daemon->submit('points=900&method=wlop&sigmaP=0.001&polish=0&anderson=4', $cloud);
$daemon->finish($still);
my $warnings = json($daemon->get("/v1/jobs/$still/results/report"))->{warnings};
is join(' ', map { $_->{about} } @$warnings), 'sigmaP anderson', 'a sigmaP below the spacing is warned of, and what only cvt uses';
is $warnings->[0]{value}, 0.001, 'with its value';
like join('|', map { $_->{says} } @$warnings), qr/no point attracts or repels another point\|anderson has an effect only with method=cvt$/, 'and what comes of it';
is_deeply $report->{warnings}, [], 'where it is wide enough there is no warning';
is $report->{orientation}, 'consistent', 'normals face consistently';
is $report->{iterations}, 12, 'projection steps count as iterations';

# Stopped while it inserts: what is missing is placed all the same.
my $short = $daemon->submit('points=100000&method=ear&samples=1000', cube_ply(34));
ok wait_until(sub { ((json($daemon->get("/v1/jobs/$short"))->{voronoid}{metrics} // {})->{run_stage} // '') eq 'insert' }),
    'another job inserts points';
$daemon->request('POST', "/v1/jobs/$short/stop");
is $daemon->finish($short)->{status}, 'successful', 'it is stopped, and succeeds';
my $stopped = json($daemon->get("/v1/jobs/$short/results/report"));
is "$stopped->{stopped} $stopped->{points}{out}", 'stopped 100000', 'with all points asked for';

# Ended while it inserts.
my $long = $daemon->submit('points=124000&method=ear&samples=1000&polish=0', cube_ply(36));
ok wait_until(sub { ((json($daemon->get("/v1/jobs/$long"))->{voronoid}{metrics} // {})->{run_stage} // '') eq 'insert' }),
    'a job inserts points';
is json($daemon->request('DELETE', "/v1/jobs/$long"))->{status}, 'dismissed', 'it is dismissed meanwhile';
is $daemon->get('/livez')->{status}, 200, 'and the daemon is well';

is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
