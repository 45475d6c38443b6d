#!/usr/bin/perl
# usage: mesh.pl VORONOID OUTDIR: our triangles beside CGAL's advancing front over our resampled points, in the same minute.
# Writes OUTDIR/mesh.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;
use JSON::PP;

my $out = begin('Meshes');
my $folder = yardstick() =~ s{/[^/]+$}{}r;
my @even = ('border <= 0', 'over <= 0', 'q_avg >= 0.935', 'q_p001 >= 0.68', 'q_min >= 0.60');
my @quick = ('hausdorff <= 0.6', 'us <= 13', 'ratio <= 1.6');
my @goal = ('q_avg >= 0.96', 'q_p001 >= 0.74', 'q_min >= 0.66', 'angle >= 42', 'hausdorff <= 0.35', 'us <= 5', 'ratio <= 1.3');
my @cases = (
    { name => 'mesh_igea', input => public('igea_mesh'), truth => public('igea_mesh'), points => 20_000, asked => [@even, @quick],
        goal => \@goal },
    { name => 'mesh_armadillo', input => public('armadillo_mesh'), truth => public('armadillo_mesh'), points => 30_000, faces => 1,
        asked => [@even, @quick], goal => \@goal },
    { name => 'mesh_fandisk', input => public('fandisk_mesh'), truth => public('fandisk_mesh'), points => 10_000, faces => 1,
        asked => [@even, @quick], goal => \@goal },
    { name => 'mesh_cow_20k', input => made('cow110k'), truth => public('cow_mesh'), points => 20_000,
        asked => ['over <= 0', 'hausdorff <= 1.5'], goal => ['border <= 0'] },
    { name => 'mesh_cow_5k', input => made('cow110k'), truth => public('cow_mesh'), points => 5000,
        asked => ['over <= 0', 'hausdorff <= 1.5'], goal => ['border <= 0'] },
    { name => 'mesh_shell', input => made('shell60k'), truth => made('shell_mesh'), points => 20_000, sheets => 60_000,
        asked => ['over <= 0', 'across <= 0'], goal => [] },
    { name => 'mesh_arma2', input => made('arma2_120k'), truth => made('arma2_mesh'), points => 40_000, sheets => 120_000,
        asked => ['over <= 0', 'across_share <= 0.01'], goal => [] },
);
my @figure = qw(n triangles border over euler q_avg q_p001 q_min angle hausdorff us across far);

# What a script of the bench tells of a mesh.
sub told {
    my ($script, @arguments) = @_;
    open my $from, '-|', '/usr/bin/python3', "tests/by_hand/bench/$script", $folder, @arguments or die "python3: $!\n";
    my $told = decode_json(join '', <$from>);
    close $from or die "$script @arguments: failed\n";
    return %$told;
}

# What a mesh is like beside the true one. Where that has several sheets, so many points of the input.
sub described {
    my ($mesh, $truth, $sheets) = @_;
    return ($sheets ? told('across.py', $mesh, $truth, $sheets) : (), told('mesh.py', $mesh, $truth));
}

# Ours, one request after that without triangles; both with their defaults.
sub ours {
    my ($case, $mesh, $points) = @_;
    my @arguments = ('--points', $case->{points}, '--threads', 1, $case->{faces} ? qw(--sample faces) : ());
    my $without = process('resample', $case->{input}, $points, @arguments);
    my $with = process('mesh', $case->{input}, $mesh, @arguments);
    my $told = $with->{report}{mesh};
    return {
        us => $told->{seconds} / $case->{points} * 1e6, ratio => $with->{cpu} / $without->{cpu}, cpu => $with->{cpu},
        rss => $with->{rss}, loops => $told->{loops},
    };
}

sub theirs {
    my ($case, $mesh, $points) = @_;
    my $run = timed(program('front'), $points, $mesh);
    my $cpu = decode_json($run->{lines}[0])->{cpu};
    return { us => $cpu / $case->{points} * 1e6, cpu => $run->{cpu}, rss => $run->{rss} };
}

sub row {
    my ($title, $runs, $figures, $asked, $goal) = @_;
    for my $of (qw(us ratio)) {
        $figures->{$of} = median(map { $_->{$of} } @$runs);
    }
    return [
        $title, map({ number($figures->{$_}) } @figure), number($figures->{ratio}), number($runs->[0]{loops}), spread('cpu', @$runs),
        sprintf('%.0f', $runs->[0]{rss}), judge($figures, @$asked), judge($figures, @$goal),
    ];
}

my @table;
for my $case (grep { wanted($_->{name}) } @cases) {
    if (my $absent = missing($case->{name}, @{$case}{qw(input truth)}, yardstick())) {
        push @table, $absent;
        next;
    }
    my ($mesh, $front, $points) = map { "$out/mesh_$_.ply" } qw(ours front points);
    my (@ours, @theirs);
    for (1 .. runs()) {
        push @ours, ours($case, $mesh, $points);
        push @theirs, theirs($case, $front, $points);
    }
    push @table, row("$case->{name}: ours", \@ours, { described($mesh, $case->{truth}, $case->{sheets}) }, $case->{asked}, $case->{goal});
    push @table, row("$case->{name}: advancing front", \@theirs, { described($front, $case->{truth}, $case->{sheets}) }, [], []);
    unlink $mesh, $front, $points;
}
exit 0 if !@table;
table([
    'case', @figure, 'ratio', 'loops', 'cpu s', 'rss MB', 'asked', 'goal',
], \@table, 'border, over: edges of one triangle, and of more than two. q: quality 6 S / (sqrt(3) p h) with half the perimeter p, its mean, '
    . 'the one in a thousand, the least; angle: the smallest, degrees. hausdorff: the farther of both ways, a million places each, in '
    . 'spacings of a hexagonal lattice. us: making the triangles, microseconds a point, ours by the clock, theirs CPU. ratio: CPU of the request over that of '
    . 'resample with its defaults. across: triangles that join two sheets; far: those of them away from where sheets cross. The advancing front (CGAL, -O3) joins the points of that resample.');
finish('mesh');
