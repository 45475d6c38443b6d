#!/usr/bin/perl
# usage: orient.pl VORONOID OUTDIR: CGAL's mst_orient_normals beside ours, on the same clouds in the same minute. Writes
# OUTDIR/orient.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;
use JSON::PP;

my $out = begin('Oriented normals');
my $folder = yardstick() =~ s{/[^/]+$}{}r;
my @cases = (
    { name => 'orient_igea30k', input => made('igea30k'), truth => public('igea_mesh'), asked => 0 },
    { name => 'orient_cow20k', input => made('cow20k'), truth => public('cow_mesh') },
    { name => 'orient_fandisk_noise2', input => made('fandisk30k_noise2'), truth => public('fandisk_mesh'), asked => 0 },
    { name => 'orient_igea655k_noisy', input => made('igea655k_noisy'), truth => public('igea_mesh'), asked => 0.001 },
);

# Share of normals that point inward.
sub inward {
    my ($cloud, $truth) = @_;
    open my $from, '-|', '/usr/bin/python3', 'tests/by_hand/bench/flips.py', $folder, $cloud, $truth or die "python3: $!\n";
    my $told = decode_json(join '', <$from>);
    close $from or die "flips.py $cloud: failed\n";
    return $told->{inward} / $told->{n};
}

# Ours is what normals=fit takes beside a request without normals: positions are the same.
sub ours {
    my ($case) = @_;
    my $result = "$out/orient.ply";
    my @arguments = ($case->{input}, $result, qw(--points 10000 --iterations 1 --polish 2 --threads 1));
    my $without = process('resample', @arguments);
    my $with = process('resample', @arguments, qw(--normals fit --inputNormals estimate));
    my %row = (cpu => $with->{cpu} - $without->{cpu}, rss => $with->{rss}, inward => inward($result, $case->{truth}));
    unlink $result;
    return \%row;
}

sub theirs {
    my ($case) = @_;
    my $result = "$out/orient.ply";
    my $run = timed(program('orient'), $case->{input}, 18, $result);
    my $told = decode_json($run->{lines}[0]);
    my %row = (cpu => $told->{fit} + $told->{orient}, rss => $run->{rss}, inward => inward($result, $case->{truth}));
    unlink $result;
    return \%row;
}

my @table;
for my $case (grep { wanted($_->{name}) } @cases) {
    if (my $absent = missing($case->{name}, @{$case}{qw(input truth)}, yardstick())) {
        push @table, $absent;
        next;
    }
    for my $who (['ours', \&ours], ['CGAL', \&theirs]) {
        my @runs = map { $who->[1]->($case) } 1 .. runs();
        push @table, [
            "$case->{name}: $who->[0]", number($runs[0]{inward}), spread('cpu', @runs), sprintf('%.0f', $runs[0]{rss}),
            $who->[0] eq 'ours' && defined $case->{asked} ? judge($runs[0], "inward <= $case->{asked}") : '-',
        ];
    }
}
exit 0 unless @table;
table(['case', 'share inward', 'CPU s', 'rss MB', 'asked'], \@table, 'Ours: what normals=fit adds to a run to 10,000 points, the '
    . 'fits of its normals included. CGAL: pca_estimate_normals and mst_orient_normals of all points, 18 neighbours, -O3. A share '
    . 'near 1 is a consistent cloud that faces inward.');
finish('orient');
