#!/usr/bin/perl
# usage: scaling.pl VORONOID OUTDIR: an iteration against the size of the input and against that of the result, on one
# torus. Writes OUTDIR/scaling.md, scaling_in.svg and scaling_out.svg.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;

my $out = begin('Scaling');
my @fixed = qw(--polish 0 --iterations 20 --threads 1);
my @series = (
    { name => 'scaling_in', what => 'points in', sizes => [map { [$_, 10_000] } 10_000, 50_000, 200_000, 1_000_000, 5_000_000] },
    { name => 'scaling_out', what => 'points out',
        sizes => [map { [1_000_000, $_] } 10_000, 20_000, 50_000, 100_000, 200_000, 500_000] },
    { name => 'scaling_in_plane', what => 'points in', sizes => [map { [$_, 10_000] } 50_000, 200_000, 1_000_000], args => [qw(--patch plane)] },
    { name => 'scaling_out_plane', what => 'points out', sizes => [map { [1_000_000, $_] } 10_000, 50_000, 200_000],
        args => [qw(--patch plane)] },
);

sub measure {
    my ($in, $points, @more) = @_;
    my ($input, $result) = (torus($in), "$out/scaling.ply");
    my @arguments = ($input, $result, '--points', $points, @fixed, @more);
    resample(@arguments) if runs() > 1;
    my @runs = map { resample(@arguments) } 1 .. runs();
    unlink $result;
    my $report = $runs[0]{report};
    my %figures = (
        in => $in, points => $points, runs => \@runs, cpu_us => median(map { $_->{cpu_us} } @runs),
        iterate => median(map { $_->{report}{seconds}{iterate} } @runs), delta => $report->{delta},
    );
    $figures{$_} = $report->{$_} || undef for qw(bisectors_per_cell triangles_per_cell);
    $figures{queries} = $report->{queries} ? $report->{queries} / $points / $runs[0]{iterations} : undef;
    return \%figures;
}

# Largest over smallest of a figure; nothing where one was not counted.
sub range {
    my ($figure, @rows) = @_;
    my @values = map { $_->{$figure} } @rows;
    my @sorted = sort { $a <=> $b } grep { defined } @values;
    return @sorted == @values ? $sorted[-1] / $sorted[0] : undef;
}

my @wanted = grep { wanted($_->{name}) } @series or exit 0;
for my $series (@wanted) {
    my @rows = map { measure(@$_, @{ $series->{args} // [] }) } @{ $series->{sizes} };
    my @figures = qw(cpu_us bisectors_per_cell triangles_per_cell queries);
    my %ratio = map { $_ => range($_, @rows) } @figures;
    my @lines = map {
        [@{$_}{qw(in points)}, number($_->{delta}), number($_->{iterate}), spread('us_iteration', @{ $_->{runs} }),
            spread('cpu_us', @{ $_->{runs} }), map { number($_) } @{$_}{@figures[1 .. 3]}]
    } @rows;
    push @lines, ['largest over smallest', ('') x 4, map { number($_) } @ratio{@figures}];
    push @lines, ['asked', ('') x 4, map { judge(\%ratio, $_) } 'cpu_us <= 1.3', map { "$_ <= 1.05" } @figures[1 .. 3]];
    table([
        'points in', 'points out', 'delta', 'iterate s', 'µs a point and iteration', 'CPU µs', 'bisectors a cell',
        'triangles a cell', 'queries a point and iteration',
    ], \@lines, join(' ', "Against $series->{what}: @fixed", @{ $series->{args} // [] }) . '.');
    my $column = $series->{name} =~ /^scaling_in/ ? 'in' : 'points';
    plot($series->{name}, ['logscale x', 'yrange [0:*]', "xlabel '$series->{what}'", "ylabel 'CPU µs a point and iteration'"],
        { title => 'iterate', style => 'linespoints', rows => [map { [$_->{$column}, $_->{cpu_us}] } @rows] });
}
finish('scaling');
