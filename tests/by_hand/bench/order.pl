#!/usr/bin/perl
# usage: order.pl VORONOID OUTDIR: how even the first points of order=progressive are, beside runs that were asked for so
# few, and what the order costs. Writes OUTDIR/order.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;
use JSON::PP;
use List::Util qw(shuffle);

my $out = begin('Order');
my @rows = (
    { name => 'order_bunny', input => public('bunny'), points => 5000 },
    { name => 'order_igea', input => public('igea_mesh'), points => 20_000 },
    { name => 'order_autzen', input => public('autzen'), points => 20_000 },
);
my @costs = map { { name => "order_torus$_", points => $_ } } 100_000, 1_000_000;
my @shares = (1 / 64, 1 / 32, 1 / 16, 0.1, 1 / 8, 1 / 4, 0.3, 0.5, 0.7, 0.9);
my @bare = qw(--attributes drop --normals drop);

# A PLY of positions alone: header, one string a point.
sub cloud {
    my ($path) = @_;
    open my $in, '<:raw', $path or die "$path: $!\n";
    local $/;
    my ($header, $body) = <$in> =~ /\A(ply\n.*?end_header\n)(.*)\z/s;
    return ($header, unpack $header =~ /^property double/m ? '(a24)*' : '(a12)*', $body);
}

sub measured {
    my (@arguments) = @_;
    return decode_json(join '', @{ timed($main::ARGV[0], 'measure', @arguments)->{lines} });
}

sub write_first {
    my ($path, $header, @points) = @_;
    my $count = @points;
    $header =~ s/^element vertex \d+/element vertex $count/m;
    open my $file, '>:raw', $path or die "$path: $!\n";
    print $file $header, @points;
    close $file or die "$path: $!\n";
    return $path;
}

# Delta of so many points, and how far the farthest of all is from them over what it is in a lattice as dense.
sub firsts {
    my ($whole, $header, @points) = @_;
    my $n = @points;
    my $gap = measured($whole)->{mean_nn} / sqrt(3);
    return map {
        my $count = int($_ * $n + 0.5);
        my $m = measured(write_first("$out/first.ply", $header, @points[0 .. $count - 1]), '--reference', $whole);
        sprintf '%.3f, %.2f', $m->{delta}, $m->{input}{ref_to_out_max} / ($gap * sqrt($n / $count));
    } @shares;
}

sub runs_of {
    my ($row, @with) = @_;
    return map {
        my $count = int($_ * $row->{points} + 0.5);
        number(resample($row->{input}, "$out/first.ply", '--points', $count, @bare, @with)->{report}{delta});
    } @shares;
}

my @wanted = grep { wanted($_->{name}) } @rows, @costs or exit 0;
my (@table, @cost);
for my $row (grep { wanted($_->{name}) } @rows) {
    if (my $absent = missing($row->{name}, $row->{input})) {
        push @table, $absent;
        next;
    }
    my $whole = "$out/whole.ply";
    resample($row->{input}, $whole, '--points', $row->{points}, @bare, '--order', 'progressive');
    my ($header, @points) = cloud($whole);
    srand 1;
    push @table, ["$row->{name} → $row->{points}", 'progressive', firsts($whole, $header, @points)],
        ['', 'a draw', firsts($whole, $header, shuffle(@points))], ['', 'a run of so many', runs_of($row)],
        ['', 'the same, --polish 0', runs_of($row, '--polish', 0)];
    unlink $whole, "$out/first.ply";
}
table(['case', 'points', map { sprintf '%.3g n', $_ } @shares], \@table,
    'Delta, and behind the comma the distance of the farthest of all n points from the first ones, over that in a perfect lattice of so '
    . 'many. The spatial order has the delta of the whole for any share, and leaves most of the surface out.');

for my $row (grep { wanted($_->{name}) } @costs) {
    my @arguments = (torus(100_000), "$out/first.ply", '--points', $row->{points}, qw(--iterations 2 --polish 2 --threads 1), @bare);
    my @pairs;
    for (1 .. runs()) {
        my %cpu = map { $_ => resample(@arguments, '--order', $_)->{cpu} } qw(spatial progressive);
        push @pairs, { %cpu, order => $cpu{progressive} - $cpu{spatial} };
    }
    push @cost, [$row->{name}, $row->{points}, map { spread($_, @pairs) } qw(spatial progressive order)];
    unlink "$out/first.ply";
}
table(['case', 'points', 'spatial, CPU s', 'progressive, CPU s', 'the order, CPU s'], \@cost,
    'Two iterations and two steps of the polish; one thread.');
finish('order');
