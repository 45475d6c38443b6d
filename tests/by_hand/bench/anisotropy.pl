#!/usr/bin/perl
# usage: anisotropy.pl VORONOID OUTDIR: cells that follow curvature: their aspects on shapes of which the truth is known, and
# how much nearer a mesh of them is. Writes OUTDIR/anisotropy.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;
use JSON::PP;

my $out = begin('Anisotropy');
my @asked = ('off_median <= 0.15', 'off_p90 <= 0.3', 'delta_metric <= 0.08');
my @goal = ('off_median <= 0.05', 'off_p90 <= 0.15', 'delta_metric <= 0.04');

sub measured {
    my @command = @_;
    open my $from, '-|', '/usr/bin/python3', @command or die "python3: $!\n";
    my $figures = decode_json(join '', <$from>);
    close $from or die "@command: failed\n";
    return $figures;
}

# The cloud of a shape and what is asked of it; fandisk's quarters of a cylinder are seven spacings high with 20,000 points.
sub cloud_of {
    my ($shape) = @_;
    my $cloud = "$out/clouds/$shape.ply";

    return (public('fandisk_mesh'), '--sample', 'faces', '--points', 20_000) if $shape eq 'fandisk';
    -e $cloud or system('/usr/bin/python3', 'tests/by_hand/bench/aspects.py', '--make', $shape, 100_000, $cloud) == 0 or die "no $shape\n";
    return ($cloud, '--points', 5000);
}

my @table;
for my $shape (grep { wanted($_) } qw(ellipsoid cylinder fandisk)) {
    my ($cloud, @asks) = cloud_of($shape);
    if (my $absent = missing($shape, $cloud)) {
        push @table, $absent;
        next;
    }
    my $result = "$out/anisotropy.ply";
    my @runs = map { resample($cloud, $result, @asks, '--metric', 'anisotropic', '--threads', 1) } 1 .. runs();
    my $figures = measured('tests/by_hand/bench/aspects.py', $result, $shape);
    unlink $result;
    push @table, [
        "$shape → $asks[-1]", map({ number($figures->{$_}) } qw(cells wanted_median aspect_median off_median off_p90 delta_metric)),
        number($runs[0]{report}{delta}), spread('cpu', @runs), judge($figures, @asked), judge($figures, @goal),
    ];
}
table(['case', qw(cells wanted aspect off_median off_p90 delta_metric), 'delta told', 'cpu s', 'asked', 'goal'], \@table,
    'off: |aspect / wanted - 1| of cells clipped in the true metric (aspects.py), nothing of the report. One thread.') if @table;

my @meshes;
for my $name (grep { wanted($_) } qw(cow fandisk)) {
    my $truth = public("${name}_mesh");
    if (my $absent = missing($name, $truth, yardstick())) {
        push @meshes, $absent;
        next;
    }
    my %row;
    for my $metric (qw(isotropic anisotropic)) {
        my $result = "$out/anisotropy.ply";
        my $run = process('mesh', $truth, $result, '--sample', 'faces', '--points', 5000, '--metric', $metric, '--threads', 1);
        $row{$metric} = { %{ measured('tests/by_hand/bench/mesh_distance.py', $result, $truth) }, cpu => $run->{cpu} };
        unlink $result;
    }
    my %figures = (over => $row{anisotropic}{mean} / $row{isotropic}{mean});
    push @meshes, [
        "$name → 5000", map({ my $metric = $_; map { number($row{$metric}{$_}) } qw(mean max cpu) } qw(isotropic anisotropic)),
        number($figures{over}), judge(\%figures, 'over <= 0.9'), judge(\%figures, 'over <= 0.6'),
    ];
}
table(['mesh', 'mean', 'max', 'cpu s', 'mean in the metric', 'max', 'cpu s', 'over', 'asked', 'goal'], \@meshes,
    'Distance of the true mesh from that of the result over its diagonal (mesh_distance.py).') if @meshes;
finish('anisotropy') if @table || @meshes;
