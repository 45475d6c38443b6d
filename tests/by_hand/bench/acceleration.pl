#!/usr/bin/perl
# usage: acceleration.pl VORONOID OUTDIR: in how many iterations Anderson acceleration is as even as fifty plain Lloyd
# iterations, and in what time. Writes OUTDIR/acceleration.md and .svg.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;

my $out = begin('Acceleration');
my @rows = (
    { name => 'anderson_bunny', input => public('bunny'), points => 5000 },
    { name => 'anderson_igea', input => public('igea_mesh'), points => 20_000 },
    { name => 'anderson_igea30k', input => made('igea30k'), points => 10_000 },
);
my @fixed = qw(--polish 0 --iterations 50 --threads 1);

sub curve {
    my ($run) = @_;
    return [map { [$_->{iteration}, $_->{delta}] } @{ $run->{records} }];
}

# Seconds of the iterations up to a record: the first record is the start.
sub since_start {
    my ($run, $record) = @_;
    return $record->{seconds} - $run->{records}[0]{seconds};
}

# Both kinds of run after each other, so that what else the machine does meets them alike.
sub measure {
    my ($row) = @_;
    my $result = "$out/$row->{name}.ply";
    my (@pairs, $lloyd, $anderson, $reached);
    for (1 .. runs()) {
        $lloyd = resample($row->{input}, $result, '--points', $row->{points}, '--anderson', 0, @fixed);
        $anderson = resample($row->{input}, $result, '--points', $row->{points}, @fixed);
        my $last = $lloyd->{records}[-1];
        ($reached) = grep { $_->{delta} <= $last->{delta} } @{ $anderson->{records} };
        my $lloyd_s = since_start($lloyd, $last);
        my $anderson_s = defined $reached ? since_start($anderson, $reached) : undef;
        push @pairs, { lloyd => $lloyd_s, anderson => $anderson_s, ratio => $anderson_s ? $anderson_s / $lloyd_s : undef };
    }
    unlink $result;
    my %figures = (
        iterations => $reached ? $reached->{iteration} : undef, reached => $reached ? $reached->{delta} : undef,
        delta => $lloyd->{records}[-1]{delta}, end => $anderson->{records}[-1]{delta},
    );
    return (\%figures, \@pairs, curve($lloyd), curve($anderson));
}

my @wanted = grep { wanted($_->{name}) } @rows or exit 0;
my (@table, @series);
for my $row (@wanted) {
    if (my $absent = missing($row->{name}, $row->{input})) {
        push @table, $absent;
        next;
    }
    my ($figures, $pairs, $lloyd, $anderson) = measure($row);
    push @table, [
        "$row->{name} → $row->{points}", number($figures->{delta}), number($figures->{reached}), $figures->{iterations} // 'more than 50',
        number($figures->{end}), map({ spread($_, @$pairs) } qw(lloyd anderson ratio)),
        judge($figures, 'iterations <= 25'), judge($figures, 'iterations <= 15'),
    ];
    push @series, { title => "$row->{name}, Lloyd", style => 'lines dashtype 2', rows => $lloyd },
        { title => $row->{name}, style => 'lines', rows => $anderson };
}
table([
    'case', 'delta of 50 Lloyd iterations', 'delta reached', 'in iterations', 'delta of 50 accelerated', 'Lloyd s', 'accelerated s',
    'ratio', 'asked', 'goal',
], \@table, 'Seconds of the iterations alone, up to the record that is as even; `--polish 0`.');
plot('acceleration', ['logscale y', "xlabel 'iteration'", "ylabel 'delta'"], @series) if @series;
finish('acceleration');
