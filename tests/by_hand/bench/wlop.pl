#!/usr/bin/perl
# usage: wlop.pl VORONOID OUTDIR: CGAL's weighted locally optimal projection beside ours, on the same clouds in the same
# minute. Writes OUTDIR/wlop.md and .svg.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;
use JSON::PP;

my $out = begin('WLOP');
my @tuple = qw(n coincident delta hex gap_max off_surface_rms);
my @cases = (
    { name => 'wlop_bunny', input => public('bunny'), truth => public('bun_zipper'), points => 5000 },
    { name => 'wlop_igea', input => public('igea_mesh'), truth => public('igea_mesh'), points => 20_000 },
);

# Who runs: ours by arguments, theirs by iterations, radius over the result's hexagonal spacing (0: their own choice) and
# uniform sampling; what is asked of our default's advantage over them.
my @runners = (
    { who => 'ours', args => [] },
    { who => 'ours --iterations 10', args => [qw(--iterations 10)] },
    { who => 'WLOP, 35 iterations, own radius', wlop => [35, 0, 0], asked => 4, goal => 10 },
    { who => 'WLOP, 100 iterations, radius 1.5, uniform', wlop => [100, 1.5, 1], asked => 1.5, goal => 3 },
);

# One run: its CPU seconds; ours leaves the area that theirs takes its radius from.
sub run_one {
    my ($case, $runner, $result) = @_;
    if ($runner->{args}) {
        my $run = resample($case->{input}, $result, '--points', $case->{points}, '--threads', 1, @{ $runner->{args} });
        $case->{area} = $run->{report}{area};
        return { cpu => $run->{cpu}, rss => $run->{rss} };
    }
    my ($iterations, $radius, $uniform) = @{ $runner->{wlop} };
    $radius *= sqrt(2 * $case->{area} / (sqrt(3) * $case->{points}));
    my $run = timed(program('wlop'), $case->{input}, $case->{points}, $iterations, $radius, $uniform, $result);
    return { cpu => decode_json($run->{lines}[0])->{cpu}, rss => $run->{rss} };
}

# Figures in which ours is not at least as good.
sub worse {
    my ($ours, $theirs) = @_;
    my @worse = grep { $ours->{$_} > $theirs->{$_} } qw(coincident delta gap_max off_surface_rms);
    push @worse, 'hex' if $ours->{hex} < $theirs->{hex};
    return @worse;
}

sub race {
    my ($case) = @_;
    my (@runs, @figures);
    for my $turn (1 .. runs()) {
        for my $i (0 .. $#runners) {
            my $result = "$out/wlop.ply";
            push @{ $runs[$i] }, run_one($case, $runners[$i], $result);
            $figures[$i] = { quality($result, $case->{truth}) } if $turn == 1;
            unlink $result;
        }
    }
    $figures[$_]{cpu} = median(map { $_->{cpu} } @{ $runs[$_] }) for 0 .. $#runners;
    return (\@runs, \@figures);
}

sub line {
    my ($case, $runner, $runs, $mine, $ours, $few) = @_;
    my @against = ('') x 6;
    if ($runner->{wlop}) {
        my @worse = worse($ours, $mine);
        my %outcome = (ratio => $mine->{cpu} / $ours->{cpu}, worse => scalar @worse);
        @against = (
            number($outcome{ratio}), join(', ', @worse) || 'nothing', number($mine->{cpu} / $few->{cpu}),
            join(', ', worse($few, $mine)) || 'nothing',
            map { judge(\%outcome, "ratio >= $runner->{$_}", 'worse <= 0') } qw(asked goal),
        );
    }
    return [
        "$case->{name}: $runner->{who}", map({ number($mine->{$_}) } @tuple), spread('cpu', @$runs),
        sprintf('%.0f', $runs->[0]{rss}), @against,
    ];
}

my @wanted = grep { wanted($_->{name}) } @cases or exit 0;
my (@table, @series);
for my $case (@wanted) {
    if (my $absent = missing($case->{name}, @{$case}{qw(input truth)}, yardstick())) {
        push @table, $absent;
        next;
    }
    my ($runs, $figures) = race($case);
    for my $i (0 .. $#runners) {
        push @table, line($case, $runners[$i], $runs->[$i], @{$figures}[$i, 0, 1]);
        my $title = "$case->{name}: $runners[$i]{who}";
        push @series, { title => $title, style => 'points pointsize 1.5', rows => [[@{ $figures->[$i] }{qw(cpu delta)}]] };
    }
}
table([
    'case', @tuple, 'CPU s', 'rss MB', 'over ours', 'ours is worse in', 'over ours at 10 iterations', 'that is worse in', 'asked', 'goal',
], \@table, 'CPU: ours the whole process, reading and writing included; theirs the algorithm alone (CGAL, Sequential_tag, -O3). The '
    . 'radius is in hexagonal spacings of the result, sqrt(2 A / (sqrt(3) n)) with A from our report.');
plot('wlop', ['logscale xy', "xlabel 'CPU s'", "ylabel 'delta'"], @series) if @series;
finish('wlop');
