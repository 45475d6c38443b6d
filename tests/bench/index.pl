#!/usr/bin/perl
# usage: index.pl VORONOID OUTDIR: what the index of five million points costs. Writes OUTDIR/index.md.
use strict;
use warnings;
use utf8;
use lib 'tests/bench';
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
    my %figures = (build => median(map { $_->{build} } @runs));
    push @table, [
        $row->{name}, $runs[0]{n}, map({ spread($_, @runs) } qw(sort build search_us)), sprintf('%.0f', $runs[0]{rss}),
        judge(\%figures, @{ $row->{asked} // [] }),
    ];
}
table(['case', 'n', 'sort, CPU s', 'build, CPU s', '20 neighbours of a point, µs', 'rss MB', 'asked'], \@table,
    'One core; the points sorted along the Morton curve before the build, as the engine does it.');
finish('index');
