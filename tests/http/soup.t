#!/usr/bin/perl
# soup=true: the cells around the points as polygons, over HTTP and here; in Draco as triangles; and what is refused.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use File::Temp 'tempdir';
use Test::More;
use Vt;

# The numbers of corners of the faces of a PLY file of float positions, and their corners.
sub faces_of {
    my ($ply) = @_;
    my ($head, $body) = $ply =~ /\A(.*?end_header\n)(.*)\z/s;
    my ($n) = $head =~ /^element vertex (\d+)$/m;
    my ($count) = $head =~ /^element face (\d+)$/m;
    my ($at, @sides, @corners) = (12 * $n);
    for (1 .. $count) {
        push @sides, unpack 'C', substr $body, $at, 1;
        push @corners, unpack 'l<*', substr $body, $at + 1, 4 * $sides[-1];
        $at += 1 + 4 * $sides[-1];
    }
    is length $body, $at, 'nothing follows the faces';
    return ($n, \@sides, \@corners);
}

my $daemon = Vt->start;
my $query = 'points=300&iterations=2&polish=3&soup=true';
my $answer = $daemon->post("/v1/mesh?$query", sphere_ply(900)); # of fewer points cells bend, and are triangles
is $answer->{status}, 200, 'a soup is made';
my ($n, $sides, $corners) = faces_of($answer->{content});
my $job = $answer->{headers}{location} =~ m{(/v1/jobs/[^/]+)\z} ? $1 : die 'no Location';
my $report = json($daemon->get("$job/results/report"));
cmp_ok scalar @$sides, '>=', 300, 'every point has a polygon or more';
is_deeply [$report->{mesh}{polygons}, $report->{mesh}{points}, $report->{points}{out}], [scalar @$sides, $n, 300], 'the report counts them';
is_deeply $corners, [0 .. $n - 1], 'every corner is a point of its own';
is scalar(grep { $_ < 3 } @$sides), 0, 'with three corners or more';
cmp_ok scalar(grep { $_ > 3 } @$sides), '>', 150, 'and mostly more';
is $report->{parameters}{soup}, JSON::PP::true, 'the report has the parameter';

my $draco = $daemon->get("$job/results/cloud?format=drc");
like $draco->{content}, qr/\ADRACO/, 'the same in Draco';
my $back = $daemon->post('/v1/convert?format=ply', $draco->{content});
is $back->{status}, 200, 'can be read';
like $back->{content}, qr/^element vertex $n$/m, 'and has as many corners';

my $refused = $daemon->post('/v1/mesh?points=60&soup=7', sphere_ply(900));
is_problem($refused, 400, 'invalid-parameter', 'a soup that is neither');
like json($refused)->{detail}, qr/soup.*true.*false/, 'the answer says what it may be';
$refused = $daemon->post('/v1/mesh?points=60&repair=maybe', sphere_ply(900));
like json($refused)->{detail}, qr/repair.*maybe.*none, auto/, 'and so of repair';
$refused = $daemon->post('/v1/resample?points=60&soup=true', sphere_ply(900));
is_problem($refused, 400, 'invalid-parameter', 'a resampling has no faces');

my $folder = tempdir(CLEANUP => 1);
spew("$folder/in.ply", sphere_ply(900));
my @command = ('mesh', "$folder/in.ply", '-o', "$folder/out.ply", qw(-n 300 --iterations 2 --polish 3 --soup --quiet -f));
is system($ENV{VORONOID} // 'build/release/voronoid', @command), 0, 'the command line makes one';
is Vt::slurp("$folder/out.ply"), $answer->{content}, 'the same bytes';
done_testing();
