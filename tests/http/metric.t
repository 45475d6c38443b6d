#!/usr/bin/perl
# A metric over HTTP: what the report tells of it, tensors of the input, the process mesh, and what is refused.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $daemon = Vt->start('admin-listen' => '127.0.0.1:0');

sub job_of { return $_[0]{headers}{location} =~ m{(/v1/jobs/[^/]+)\z} ? $1 : die 'no Location' }
sub report_of { return json($daemon->get(job_of($_[0]) . '/results/report')) }

# n points of a square that carry the tensor "shape", of aspect 3 along y; its part xy at point 3 is given.
sub square {
    my ($n, $xy) = @_;
    my $text = "ply\nformat ascii 1.0\nelement vertex $n\n";
    $text .= "property float $_\n" for qw(x y z), map { "shape_$_" } qw(xx xy xz yy yz zz);
    my @rows = map { my $turn = $_ * 0.618034; join ' ', $turn - int $turn, $_ / $n, 0, 9, $_ == 3 ? $xy : 0, 0, 1, 0, 1 } 0 .. $n - 1;
    return $text . "end_header\n" . join("\n", @rows) . "\n";
}

my $few = 'points=200&iterations=6&polish=20';
my $even = $daemon->post("/v1/resample?$few", square(1500, 0));
is $even->{status}, 200, 'without a metric' or diag($even->{content});
ok !exists report_of($even)->{metric}, 'the report tells of none';

my $long = $daemon->post("/v1/resample?$few&metric=attribute:shape", square(1500, 0));
is $long->{status}, 200, 'tensors of the input are followed' or diag($long->{content});
my $told = report_of($long)->{metric};
is_deeply [sort keys %$told], [qw(aspect_median aspect_p95 cells_median off_median off_p90)], 'the report tells how';
cmp_ok abs($told->{aspect_median} - 3), '<', 0.01, 'what they ask for';
cmp_ok abs($told->{cells_median} / 3 - 1), '<', 0.15, 'and what cells came to';
is report_of($long)->{parameters}{metric}, 'attribute:shape', 'and which ones';

my $capped = $daemon->post("/v1/resample?$few&metric=attribute:shape&maxAspect=2", square(1500, 0));
cmp_ok abs(report_of($capped)->{metric}{aspect_median} - 2), '<', 0.01, 'maxAspect bounds it';

is_problem($daemon->post("/v1/resample?$few&metric=attribute:shape", square(1500, 4)), 422, 'unusable-metric', 'no positive tensor')
    and like json($daemon->post("/v1/resample?$few&metric=attribute:shape", square(1500, 4)))->{detail},
    qr/^tensor shape is 9 4 0 1 0 1 \(xx xy xz yy yz zz\) at point 3, want a positive definite tensor/, 'the first point is named';

my $mesh = $daemon->post('/v1/mesh?points=300&polish=20&metric=anisotropic', sphere_ply(3000));
is $mesh->{status}, 200, 'mesh takes a metric' or diag($mesh->{content});
cmp_ok abs(report_of($mesh)->{metric}{aspect_median} - 1), '<', 0.1, 'a sphere asks for no direction';
is report_of($mesh)->{mesh}{closed}, 'yes', 'and its mesh is closed';
is $daemon->metric('job_duration_seconds_count\{process="mesh",stage="mesh"\}'), 1, 'whose time is counted';

is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
