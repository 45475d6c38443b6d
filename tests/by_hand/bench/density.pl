#!/usr/bin/perl
# usage: density.pl VORONOID OUTDIR: how results follow a density and what that costs, how right curvatures are, and how even
# simple methods are beside the result. Writes OUTDIR/density.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;
use JSON::PP;

my $out = begin('Density, curvature, baselines');
my $tools = yardstick() =~ s{[^/]+$}{}r;
my @followed = ('slope_off <= 0.02', 'delta <= 0.06', 'span >= 50', 'ratio <= 1.6');
my @followed_goal = ('slope_off <= 0.01', 'delta <= 0.03', 'ratio <= 1.25');
my @dense = (
    { name => 'density_armadillo1m', input => 'armadillo1m', points => 20_000, density => 'curvature',
        make => "sample_mesh(*mesh('armadillo_mesh.ply'), 1_000_000, 7)[0]", asked => \@followed, goal => \@followed_goal },
    { name => 'density_igea655k', input => 'igea655k', points => 20_000, density => 'curvature',
        asked => [@followed[0, 1, 3]], goal => \@followed_goal },
    { name => 'density_fandisk_edges', input => 'fandisk30k', points => 6000, density => 'edges',
        make => "sample_mesh(*mesh('fandisk_mesh.ply'), 30_000, 4)[0]", asked => [@followed[0, 1, 3]] },
);
my @right = (
    { neighbors => 32, asked => ['median <= 0.005', 'p95 <= 0.02'], goal => ['median <= 0.001', 'p95 <= 0.005'] },
    { neighbors => 64, asked => ['median <= 0.005', 'p95 <= 0.02'], goal => ['median <= 0.001', 'p95 <= 0.005'] },
    { neighbors => 20 },
);
my @beside = (
    { name => 'baselines_cow110k', input => 'cow110k', points => 5000 },
    { name => 'baselines_cow110k_plane', input => 'cow110k', points => 5000, args => [qw(--patch plane)] },
);

# The cloud of a row: the yardstick's, or one that its tools make here.
sub cloud {
    my ($row) = @_;
    my $path = made($row->{input});
    return $path if -e $path || !$row->{make} || !-r "${tools}makeclouds.py";
    my $script = "import sys; sys.path.insert(0, '$tools'); from cloudio import *; from makeclouds import mesh; "
        . "write_ply('$path', $row->{make})";
    system('/usr/bin/python3', '-c', $script) == 0 or die "no $path\n";
    return $path;
}

# Runs with and without the density, one after the other, so that both meet the same machine.
sub follow {
    my ($row) = @_;
    my ($input, $result) = (cloud($row), "$out/$row->{name}.ply");
    my @arguments = ('--points', $row->{points}, '--threads', 1);
    my @with = (@arguments, '--density', $row->{density});
    resample($input, $result, @arguments) if runs() > 1;
    my @pairs = map { [resample($input, $result, @arguments), resample($input, $result, @with)] } 1 .. runs();
    my $said = decode_json(timed(program('density'), $input, $result, $row->{density})->{lines}[0]);
    unlink $result;
    $_->[1]{ratio} = $_->[1]{cpu} / $_->[0]{cpu} for @pairs;
    return ($pairs[0][1]{report}, $said, @pairs);
}

sub density_row {
    my ($row) = @_;
    my ($report, $said, @pairs) = follow($row);
    my %figures = (%$said, slope_off => abs($said->{slope} + 0.25), ratio => median(map { $_->[1]{ratio} } @pairs));
    return [
        "$row->{name} → $row->{points} $row->{density}", map({ number($_) } $report->{points}{out}, @{$said}{qw(slope delta span)}),
        number($report->{density}{spacing_max} / $report->{density}{spacing_min}), spread('cpu', map { $_->[0] } @pairs),
        map({ spread($_, map { $_->[1] } @pairs) } qw(cpu ratio wall)), judge(\%figures, @{ $row->{asked} // [] }),
        judge(\%figures, @{ $row->{goal} // [] }),
    ];
}

sub curvature_rows {
    my ($row) = @_;
    my @shapes = map { decode_json($_) } @{ timed(program('curvature'), $row->{neighbors})->{lines} };
    return map {
        [
            "$_->{name}, $row->{neighbors}", map({ number($_) } @{$_}{qw(median p95 most us)}), judge($_, @{ $row->{asked} // [] }),
            judge($_, @{ $row->{goal} // [] }),
        ]
    } @shapes;
}

# The result and each baseline, from one report, and what the baselines cost together.
sub baseline_rows {
    my ($row) = @_;
    my ($input, $result) = (made($row->{input}), "$out/$row->{name}.ply");
    my $run = resample($input, $result, '--points', $row->{points}, '--threads', 1, '--baselines', @{ $row->{args} // [] });
    unlink $result;
    my $report = $run->{report};
    my ($stage) = grep { $_->{stage} eq 'baselines' } @{ $report->{stages} };
    my %rows = (result => $report, %{ $report->{baselines} });
    return map {
        my $told = $rows{$_};
        [
            "$row->{name}, $_", $_ eq 'result' ? $report->{points}{out} : $told->{points},
            map({ number($told->{$_}) } qw(delta sigma six_share)),
            map({ number($told->{ref_to_out}{$_} / $report->{spacing}) } qw(mean max)),
            $_ eq 'result' ? number($run->{engine}) : $_ eq 'farthest' ? number($stage->{seconds}) : '',
        ]
    } qw(result kmeans random voxel farthest);
}

my (@first, @second, @third);
for my $row (grep { wanted($_->{name}) } @dense) {
    push @first, missing($row->{name}, cloud($row)) // density_row($row);
}
push @second, map { curvature_rows($_) } @right if wanted('curvature');
for my $row (grep { wanted($_->{name}) } @beside) {
    my $absent = missing($row->{name}, made($row->{input}));
    push @third, $absent // baseline_rows($row);
}
exit 0 unless @first + @second + @third;
table(['case', 'n', qw(slope delta span), 'spacing max / min', 'uniform cpu s', 'cpu s', 'ratio', 'wall s', 'asked', 'goal'], \@first,
    'Slope of the logarithm of the distance to the nearest point over that of the density followed, in 20 bins with as many points each: '
    . '-0.25 is asked for, slope_off is what it is off. Delta: of those distances times the density to the power 1/4. Span: 95th over '
    . '5th percentile of the density followed. Ratio: cpu with the density over that without, in pairs of runs. One thread.');
table(['case, neighbours', qw(median p95 most), 'CPU µs', 'asked', 'goal'], \@second,
    'Errors of principal curvatures over the larger one without its sign, of 50,000 exact points, at 5,000 of them. CPU: the fit and the '
    . 'curvature, without the search.');
table(['case', 'points', qw(delta sigma six_share), 'input to points, mean', 'max', 'seconds'], \@third,
    'As many points by simple methods on the same input. Distances from the input are over the spacing of the result. Seconds: of the '
    . 'engine without baselines, and of all baselines with what measures them. One thread.');
finish('density');
