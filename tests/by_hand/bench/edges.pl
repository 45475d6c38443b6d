#!/usr/bin/perl
# usage: edges.pl VORONOID OUTDIR: the sharp edges found of clouds, beside those of their meshes. Writes OUTDIR/edges.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;
use JSON::PP;

my $out = begin('Edges');
my @rows = (
    { name => 'edges_fandisk30k', mesh => 'fandisk_mesh', input => 'fandisk30k',
        make => "sample_mesh(*mesh('fandisk_mesh.ply'), 30_000, 4)[0]", asked => ['precision >= 0.9', 'recall >= 0.9', 'us <= 6'] },
    { name => 'edges_fandisk30k_noise2', mesh => 'fandisk_mesh', input => 'fandisk30k_noise2',
        asked => ['precision >= 0.9', 'recall >= 0.9'] },
    { name => 'edges_fandisk30k_noisy', mesh => 'fandisk_mesh', input => 'fandisk30k_noisy' },
    { name => 'edges_igea30k', mesh => 'igea_mesh', input => 'igea30k', asked => ['share <= 0.005', 'us <= 6'] },
    { name => 'edges_sphere30k', input => 'sphere30k', make => '(lambda p: p / np.linalg.norm(p, axis=1)[:, None])'
        . '(np.random.default_rng(1).normal(size=(30_000, 3)))', asked => ['share <= 0.005', 'us <= 6'] },
    { name => 'edges_armadillo120k', mesh => 'armadillo_mesh', input => 'armadillo_vox120k' },
    { name => 'edges_cow20k', mesh => 'cow_mesh', input => 'cow20k' },
);

# The cloud of a row: the yardstick's, or one that its tools make here.
sub cloud {
    my ($row) = @_;
    my $path = made($row->{input});
    my $tools = yardstick() =~ s{[^/]+$}{}r;
    return $path if -e $path || !$row->{make} || !-r "${tools}makeclouds.py";
    my $script = "import sys; sys.path.insert(0, '$tools'); from cloudio import *; from makeclouds import mesh; "
        . "write_ply('$path', $row->{make})";
    system('/usr/bin/python3', '-c', $script) == 0 or die "no $path\n";
    return $path;
}

sub measure {
    my ($row) = @_;
    my $run = timed(program('edges'), cloud($row), $row->{mesh} ? public($row->{mesh}) : '-');
    return decode_json($run->{lines}[0]);
}

my @wanted = grep { wanted($_->{name}) } @rows or exit 0;
my @table;
for my $row (@wanted) {
    if (my $absent = missing($row->{name}, cloud($row), $row->{mesh} ? public($row->{mesh}) : ())) {
        push @table, $absent;
        next;
    }
    measure($row) if runs() > 1;
    my @runs = map { measure($row) } 1 .. runs();
    my $first = $runs[0];
    my %figures = (%$first, us => median(map { $_->{us} } @runs));
    push @table, [
        $row->{name}, $first->{n}, $first->{neighbors}, map({ number($first->{$_}) } qw(precision recall)),
        sprintf('%.2f', 100 * $first->{share}), map({ number($first->{$_}) } qw(length length_true)), spread('us', @runs),
        judge(\%figures, @{ $row->{asked} // [] }),
    ];
}
table(['case', 'n', 'neighbours', 'precision', 'recall', 'flagged, %', 'length', 'true length', 'CPU, µs a point', 'asked'], \@table,
    'Against the edges of the mesh between faces whose normals differ by more than 30 degrees. Spacing: √(area / n). A flagged point is '
    . 'right within 1.5 spacings of such an edge; of places on the edges, half a spacing apart, those are found that have a flagged point '
    . 'within 1.5 spacings. igea and the sphere are asked to have none: what igea, the armadillo and the cow have in their meshes are '
    . 'folds and facets that are no edges at the spacing of the points. One thread; the index is not in the time.');
finish('edges');
