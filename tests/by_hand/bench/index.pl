#!/usr/bin/perl
# usage: index.pl VORONOID OUTDIR: what the index of five million points costs. Writes OUTDIR/index.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;
use JSON::PP;

my $out = begin('Index');
my @rows = (
    { name => 'index_torus1m', input => wanted('index_torus1m') ? torus(1_000_000) : '' },
    { name => 'index_armadillo5m', input => made('armadillo5m_uneven'), asked => ['build <= 0.5'] },
    { name => 'index_torus5m', input => wanted('index_torus5m') ? torus(5_000_000) : '', asked => ['build <= 0.5'] },
);

sub measure {
    my ($row) = @_;
    my $run = timed(program('index'), $row->{input});
    return { %{ decode_json($run->{lines}[0]) }, rss => $run->{rss} };
}

my @wanted = grep { wanted($_->{name}) } @rows or exit 0;
my @table;
for my $row (@wanted) {
    if (my $absent = missing($row->{name}, $row->{input})) {
        push @table, $absent;
        next;
    }
    measure($row) if runs() > 1;
    my @runs = map { measure($row) } 1 .. runs();
    my %figures = (build => median(map { $_->{boxes_build} } @runs));
    my $judged = judge(\%figures, @{ $row->{asked} // [] });
    for my $kind (qw(flann boxes)) {
        push @table, [
            $row->{name}, $runs[0]{n}, $kind, spread('sort', @runs), spread("${kind}_build", @runs),
            $kind eq 'boxes' ? spread('build_two', @runs) : '',
            map({ spread("${kind}_$_", @runs) } 1, 20, 32, 150, 'batch'),
            $kind eq 'boxes' ? $judged : '',
        ];
    }
}
table(['case', 'n', 'structure', 'sort, CPU s', 'build, CPU s', 'build on two threads, s', 'k = 1, µs', 'k = 20, µs', 'k = 32, µs',
        'k = 150, µs', 'k = 20, 250 a call, µs', 'asked'], \@table,
    'One core but where it says two; both structures over the same points, sorted along the Morton curve, in the same process; one query a '
    . 'call but where it says 250. `boxes`, the tree of boxes, indexes the input: it is sorted anyway, and the engine asks for one seed at a '
    . 'time. `flann` indexes what comes in any order: the seeds, and both clouds of `measure`.');
finish('index');
