#!/usr/bin/perl
# usage: real.pl VORONOID OUTDIR: scans, noise, octrees and sheets: the processes with no parameter but the count. Writes
# OUTDIR/real.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;

my $out = begin('Real input');
my ($igea, $armadillo, $fandisk) = map { public("${_}_mesh") } qw(igea armadillo fandisk);
my @exact = ('coincident <= 0');
my @on_data = (@exact, 'far <= 2');
my @rows = (
    { name => 'autzen', input => public('autzen'), points => 20_000, asked => [@on_data, 'delta <= 0.19'], goal => ['delta <= 0.12'] },
    { name => 'office1', input => public('office1'), points => 50_000, asked => [@on_data, 'delta <= 0.19'], goal => ['delta <= 0.12'] },
    { name => 'kitti', input => public('kitti_000008'), points => 5000, asked => \@on_data, goal => ['delta <= 0.2'] },
    { name => 'scannet', input => public('scannet'), points => 10_000, asked => \@on_data, goal => ['delta <= 0.12'] },
    { name => 'igea655k_noisy', process => 'denoise', input => made('igea655k_noisy'), truth => $igea, points => 100_000,
        asked => ['delta <= 0.06', 'off_surface_rms <= 3.8e-4'], goal => ['delta <= 0.04', 'off_surface_rms <= 3.0e-4'] },
    { name => 'igea655k_resample', input => made('igea655k'), truth => $igea, points => 100_000 },
    { name => 'igea655k', process => 'denoise', input => made('igea655k'), truth => $igea, points => 100_000,
        asked => ['over_resample <= 1.1'] },
    octree(6, [1.3e-3, 0.08, 7e-3], [1.0e-3, 0.05, 4e-3]),
    octree(7, [7e-4, 0.08, 7e-3], [5.5e-4, 0.05, 4e-3]),
    octree(8, [4.5e-4, 0.08, 7e-3], [3.5e-4, 0.05, 4e-3]),
    { name => 'vox120k', process => 'upsample', input => made('armadillo_vox120k'), truth => $armadillo, points => 480_000,
        asked => ['delta <= 0.087', 'off_surface_mean <= 2.2e-4', 'cpu <= 20'], goal => ['delta <= 0.05', 'cpu <= 10'] },
    { name => 'noise2_plain', input => made('fandisk30k_noise2'), truth => $fandisk, points => 10_000,
        args => [qw(--polish 0 --neighbors 20)] },
    { name => 'noise2', input => made('fandisk30k_noise2'), truth => $fandisk, points => 10_000,
        asked => ['off_surface_rms <= noise2_plain.off_surface_rms'] },
    # The input's own points, smoothed: half and 0.35 times its own distance from the truth, 1.99e-3.
    { name => 'noise2_mls', process => 'denoise', input => made('fandisk30k_noise2'), truth => $fandisk,
        args => [qw(--filters mls)], asked => ['off_surface_rms <= 9.9e-4'], goal => ['off_surface_rms <= 7e-4'] },
);

sub octree {
    my ($bits, $asked, $goal) = @_;
    my @figures = qw(off_surface_rms delta off_surface_max);
    return {
        name => "igea34k_oct$bits", process => 'upsample', input => made("igea34k_oct$bits"), truth => $igea, points => 34_000,
        asked => [map { "$figures[$_] <= $asked->[$_]" } 0 .. 2], goal => [map { "$figures[$_] <= $goal->[$_]" } 0 .. 2],
    };
}

my (@table, %rms);
for my $row (grep { wanted($_->{name}) } @rows) {
    if (my $absent = missing($row->{name}, grep({ defined } @{$row}{qw(input truth)}), yardstick())) {
        push @table, $absent;
        next;
    }
    my $result = "$out/real.ply";
    my $process = $row->{process} // 'resample';
    my @arguments = ((defined $row->{points} ? ('--points', $row->{points}) : ()), @{ $row->{args} // [] }, '--threads', 1);
    my @runs = map { process($process, $row->{input}, $result, @arguments) } 1 .. runs();
    my %figures = against($result, $row->{input}, $row->{truth});
    unlink $result;
    my $report = $runs[0]{report};
    $figures{cpu} = median(map { $_->{cpu} } @runs);
    $rms{ $row->{name} } = $figures{off_surface_rms};
    $figures{over_resample} = $figures{off_surface_rms} / $rms{igea655k_resample}
        if $row->{name} eq 'igea655k' && $rms{igea655k_resample};
    remember($row->{name}, \%figures);
    push @table, [
        join(' ', "$row->{name} → " . ($row->{points} // 'as many'), $process, @{ $row->{args} // [] }),
        map({ number($figures{$_}) } qw(n coincident delta far off_surface_rms off_surface_mean off_surface_max)),
        number($report->{parameters}{neighbors}), number($report->{outliers}), spread('cpu', @runs),
        sprintf('%.0f', $runs[0]{rss}), judge(\%figures, @{ $row->{asked} // [] }), judge(\%figures, @{ $row->{goal} // [] }),
    ];
}
exit 0 if !@table;
table([
    'case', qw(n coincident delta far off_surface_rms off_surface_mean off_surface_max neighbors outliers), 'cpu s', 'rss MB',
    'asked', 'goal',
], \@table, 'far: the farthest point from the input over the 99.9th percentile of distances to the sixth neighbour '
    . '(far_over_knn6_p999). cpu: the whole process, file to file, one thread.');
finish('real');
