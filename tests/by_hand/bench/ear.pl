#!/usr/bin/perl
# usage: ear.pl VORONOID OUTDIR: edge-aware resampling (Huang et al. 2013) beside cvt and beside CGAL's edge-aware upsampling and
# bilateral smoothing, in the same minute. Writes OUTDIR/ear.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;
use JSON::PP;

my $out = begin('Edges kept');
my $folder = yardstick() =~ s{/[^/]+$}{}r;
my $fandisk = public('fandisk_mesh');
my @python = ('/usr/bin/python3');

# What the measure says of a cloud of the fandisk, or of another mesh.
sub measured {
    my ($result, $noise, %how) = @_;
    my @command = (@python, 'tests/by_hand/bench/edge_measure.py', $folder, $result, $how{truth} // $fandisk, $noise, $how{input} // ());
    my $told = decode_json(timed(@command)->{lines}[0]);
    return %$told;
}

# A cloud that the yardstick does not make.
sub own {
    my ($name) = @_;
    my $path = made($name);
    return $path if -e $path || !-r yardstick();
    timed(@python, 'tests/by_hand/bench/ear_clouds.py', $folder, "$out/clouds");
    return $path;
}

# One run of ours, with its first command (an upsampling) where it has one, or of CGAL's: NEIGHBORS SMOOTHINGS SENSITIVITY RADIUS
# POINTS, its CPU that of all its steps.
sub run_one {
    my ($runner, $input, $result) = @_;
    if ($runner->{cgal}) {
        my $run = timed(program('ear'), $input, @{ $runner->{cgal} }, $result);
        return { cpu => decode_json($run->{lines}[0])->{cpu}, rss => $run->{rss} };
    }
    my ($first, $cpu, $rss) = ("$out/ear_first.ply", 0, 0);
    if ($runner->{first}) {
        my $run = process('upsample', $input, $first, qw(--threads 1), @{ $runner->{first} });
        ($input, $cpu, $rss) = ($first, $run->{cpu}, $run->{rss});
    }
    my $run = process($runner->{process} // 'upsample', $input, $result, qw(--threads 1), @{ $runner->{args} });
    my %told = map { $_->{stage} => $_->{seconds} } @{ $run->{report}{stages} };
    $rss = $run->{rss} if $run->{rss} > $rss;
    unlink $first;
    return { cpu => $cpu + $run->{cpu}, rss => $rss, init => $run->{report}{seconds}{init}, %told };
}

# Runs each of a case's runners in turn; $figures of the first result of each.
sub race {
    my ($case, $figures) = @_;
    my @told;
    for my $runner (@{ $case->{runners} }) {
        my $result = "$out/ear.ply";
        run_one($runner, $case->{input}, $result) if runs() > 1;
        my @runs = map { run_one($runner, $case->{input}, $result) } 1 .. runs();
        my %told = ($figures->($result), runs => \@runs);
        for my $of (qw(cpu rss init project insert polish)) {
            $told{$of} = median(map { $_->{$of} } @runs);
        }
        push @told, \%told;
        unlink $result;
    }
    return @told;
}

# A section of the page: its cases, the figures in its columns, what a result's figures are.
sub section {
    my ($columns, $sentence, $figures, @cases) = @_;
    my @table;
    for my $case (grep { wanted($_->{name}) } @cases) {
        if (my $absent = missing($case->{name}, $case->{input}, $case->{truth} // $fandisk, yardstick())) {
            push @table, $absent;
            next;
        }
        my @told = race($case, sub { $figures->($case, @_) });
        $case->{after}->(@told) if $case->{after};
        for my $i (0 .. $#told) {
            my $runner = $case->{runners}[$i];
            push @table, [
                "$case->{name}: $runner->{who}", map({ number($told[$i]{$_}) } @$columns), spread('cpu', @{ $told[$i]{runs} }),
                sprintf('%.0f', $told[$i]{rss}), judge($told[$i], @{ $runner->{asked} // [] }), judge($told[$i], @{ $runner->{goal} // [] }),
            ];
        }
    }
    table(['case', @$columns, 'CPU s', 'rss MB', 'asked', 'goal'], \@table, $sentence);
    return;
}

my @cvt = qw(--normals fit);
my @ear = qw(--method ear);

# Wedges of two squares, over seeds.
sub wedges {
    my @runners = (
        { who => 'cvt', command => [$ARGV[0], qw(resample IN -n 1000 --threads 1 -q -f -o OUT), @cvt] },
        { who => 'ear', command => [$ARGV[0], qw(resample IN -n 1000 --threads 1 -q -f -o OUT), @ear], asked => 1 },
        { who => 'bilateral twice, then EAR', command => [program('ear'), qw(IN 24 2 0 0 2000 OUT)] },
    );
    my @figure = qw(n near off p99 normal normal_p90 smeared reach cpu);
    my @table;
    for my $runner (@runners) {
        my $run = timed(@python, 'tests/by_hand/bench/wedges.py', $folder, $out, 20, @{ $runner->{command} });
        for my $told (map { decode_json($_) } @{ $run->{lines} }) {
            my $right = $told->{angle} == 90;
            my @asked = ('normal <= 4', 'normal_p90 <= 15', $right ? 'smeared <= 0.05' : 'smeared <= 0.01');
            my @goal = ('normal <= 2', 'normal_p90 <= 5', $told->{noise} < 0.0075 ? 'smeared <= 0' : 'smeared <= 0.005');
            push @table, [
                sprintf('%d°, noise %.1f %%: %s', $told->{angle}, 100 * $told->{noise}, $runner->{who}), map({ number($told->{$_}) } @figure),
                $runner->{asked} ? (judge($told, @asked), judge($told, @goal)) : ('-', '-'),
            ];
        }
    }
    table(['ear_wedges', @figure, 'asked', 'goal'], \@table, 'Two unit squares that meet at an angle, 1,000 points with Gaussian noise, 20 '
        . 'seeds, to 1,000 points; of those within two spacings of the edge: distance to the faces over the noise (mean, p99), angle of the '
        . 'normal to that of the face (median, p90), share whose normal is more than 30 degrees from both faces or that lie farther than two '
        . 'noises off; reach: from the edge to the nearest point, in spacings, mean. cpu: mean of a run.');
    return;
}

my $near = 'Lengths over the diagonal of the mesh. Near: within 0.01 of an edge of more than 30 degrees; mean, p99: distance of near points '
    . 'to the faces; normal: angle to that of the face, median; smeared: share of near points whose normal is more than 30 degrees from both '
    . 'faces, or farther than two noises off; reach: from the edge to the nearest point, mean. CPU: ours the whole process; CGAL (-O3, '
    . 'Sequential_tag, 24 neighbours, 15 degrees, its own radius) normals, smoothing and upsampling; it is asked for the input\'s points '
    . 'more, which it does not return.';

wedges() if wanted('ear_wedges') && -r yardstick();

my @dense = qw(-n 120000);
section([qw(n near mean p99 normal normal_p90 smeared reach delta insert)], $near, sub { my ($case, $result) = @_; return measured($result, 0.002) }, {
    name => 'ear_fandisk_120k', input => made('fandisk30k_noise2'), after => sub {
        remember($_->[0], $_->[1]) for ['rho0', $_[2]], ['rho5', $_[3]], ['cgal', $_[5]];
    }, runners => [
        { who => 'cvt', args => [@dense, @cvt] },
        { who => 'ear, rho 0, no polish', args => [@dense, @ear, qw(--rho 0 --polish 0)], asked => ['delta <= 0.20'], goal => ['delta <= 0.15'] },
        { who => 'ear, rho 0', args => [@dense, @ear, qw(--rho 0)],
            asked => ['mean <= 5.5e-4', 'p99 <= 2.0e-3', 'normal <= 5', 'reach <= 1.6e-3', 'delta <= 0.10'],
            goal => ['mean <= 3.5e-4', 'p99 <= 1.2e-3', 'normal <= 2', 'reach <= 1.0e-3', 'delta <= 0.05'] },
        { who => 'ear, rho 5', args => [@dense, @ear, qw(--rho 5)], asked => ['n >= 120000', 'near >= rho0.near', 'insert <= cgal.cpu'], goal => ['insert <= 1'] },
        { who => 'ear, rho 10', args => [@dense, @ear, qw(--rho 10)], asked => ['n >= 120000', 'near >= rho5.near', 'insert <= cgal.cpu'], goal => ['insert <= 1'] },
        { who => 'EAR', cgal => [qw(24 0 0 0 150000)] },
        { who => 'bilateral twice, then EAR', cgal => [qw(24 2 0 0 150000)] },
        { who => 'EAR, sensitivity 0.2', cgal => [qw(24 0 0.2 0 150000)] },
    ],
});

section([qw(n near rms_over_input near_over_input clean_over_input normal smeared delta)], 'The same; rms over that of the input: of all '
    . 'points, of those near edges, of the others.', sub {
        my ($case, $result) = @_;
        return measured($result, 0.005, input => $case->{input});
    }, {
        name => 'ear_fandisk_noisy', input => made('fandisk30k_noisy'), after => sub { remember('cvt', $_[0]) }, runners => [
            { who => 'cvt', args => [qw(-n 40000), @cvt] },
            { who => 'ear', args => [qw(-n 40000 --samples 10000), @ear],
                asked => ['rms_over_input <= 0.32', 'near_over_input <= 0.5', 'clean_over_input <= cvt.clean_over_input'],
                goal => ['rms_over_input <= 0.25', 'near_over_input <= 0.3'] },
            { who => 'bilateral four times, then EAR', cgal => [qw(24 4 0 0 70000)] },
        ],
    });

# Outliers are counted farther off than noise takes a point: of those moved, how many are left.
section([qw(n near mean p99 gone normal smeared)], 'The same, 163,000 points with noise of up to 2 % of the diagonal; one in a hundred '
    . 'moved by up to 10 %. gone: share of the outliers that no longer lie off by more than the noise.', sub {
        my ($case, $result) = @_;
        my %told = measured($result, 0.02);
        my ($given, $left) = map { outlying($_) } $case->{input}, $result;
        return (%told, gone => 1 - $left / $told{n} / ($given / 163_000));
    }, {
        name => 'ear_fandisk_rough', input => own('fandisk163k_rough'), runners => [
            { who => 'ear', process => 'resample', args => [qw(-n 40000), @ear], asked => ['gone >= 0.99', 'p99 <= 0.01'],
                goal => ['gone >= 0.999', 'p99 <= 0.006'] },
            { who => 'ear, outliers dropped', process => 'resample', args => [qw(-n 40000 --outliers drop), @ear],
                asked => ['gone >= 0.99', 'p99 <= 0.01'], goal => ['gone >= 0.999', 'p99 <= 0.006'] },
            { who => 'bilateral four times', cgal => [qw(48 4 0 0 0)] },
        ],
    });

# Points of a cloud farther from the fandisk than its noise takes them.
sub outlying {
    my ($cloud) = @_;
    my $script = "import sys; sys.path.insert(0, '$folder'); from cloudio import *; from surface import Surface; "
        . "v, f = read_ply('$fandisk'); s = Surface(xyz(v), f, 400_000); "
        . "print(int((s.distance(xyz(read_ply('$cloud')[0])) > 0.0201 * s.diagonal).sum()))";
    return timed(@python, '-c', $script)->{lines}[0] + 0;
}

my $armadillo = public('armadillo_mesh');
section([qw(n all_rms delta init project insert polish us)], 'Times of one thread; us: insertion, microseconds a point. Huang et al.: 49 s, and '
    . '42 s for the second phase.', sub {
        my ($case, $result) = @_;
        my %told = measured($result, 0.001, truth => $armadillo);
        return %told;
    }, map({ {
        name => $_->[0], input => own('armadillo222k_noisy'), truth => $armadillo, after => sub {
            $_->{us} = $_->{insert} / ($_->{n} - 22_000) * 1e6 for grep { $_->{insert} && $_->{n} > 22_000 } @_;
        }, runners => $_->[1],
    } }
    ['ear_armadillo_22k', [
        { who => 'ear', process => 'resample', args => [qw(-n 22000), @ear], asked => ['cpu <= 4'], goal => ['cpu <= 1.5'] },
        { who => 'cvt', process => 'resample', args => [qw(-n 22000)] },
    ]],
    ['ear_armadillo_800k', [
        { who => 'ear', args => [qw(-n 800000 --samples 22000), @ear], asked => ['insert <= 8'], goal => ['insert <= 4'] },
    ]],
));

my $igea = public('igea_mesh');
section([qw(n all_rms delta)], 'Where there are no edges.', sub {
        my ($case, $result) = @_;
        return measured($result, 0, truth => $igea);
    }, {
        name => 'ear_igea_10k', input => made('igea30k'), truth => $igea, after => sub {
            my ($cvt, $ear) = @_;
            $ear->{ratio} = $ear->{all_rms} / $cvt->{all_rms};
        }, runners => [
            { who => 'cvt', process => 'resample', args => [qw(-n 10000)] },
            { who => 'ear', process => 'resample', args => [qw(-n 10000), @ear], asked => ['ratio <= 1.2', 'delta <= 0.04'], goal => ['ratio <= 1'] },
        ],
    });

# Of meshes: the mean distance of their triangles' corners and of places on them is the same measure, by a fine sampling of the mesh.
my @bars = (asked => ['ratio <= 0.7'], goal => ['ratio <= 0.4']);
section([qw(n near mean p99 reach ratio)], 'Triangles over 10,000 points: 400,000 places of each mesh, those within 0.01 diagonal of an edge. '
    . 'ratio: mean over that of cvt. CPU and rss: of two commands the sum and the larger.', sub {
        my ($case, $result) = @_;
        return sampled($result);
    }, {
        name => 'ear_mesh', input => made('fandisk30k_noisy'), after => sub { $_->{ratio} = $_->{mean} / $_[0]{mean} for @_ }, runners => [
            { who => 'cvt', process => 'mesh', args => [qw(-n 10000)] },
            { who => 'ear', process => 'mesh', args => [qw(-n 10000), @ear] },
            { who => 'upsample by ear, then mesh', process => 'mesh', first => \@ear, args => [qw(-n 10000)], @bars },
            { who => 'the same, 10,000 samples to 40,000', process => 'mesh', first => [qw(-n 40000 --samples 10000), @ear],
                args => [qw(-n 10000)], @bars },
        ],
    });

# The measure of places drawn from a mesh.
sub sampled {
    my ($mesh) = @_;
    my $script = "import sys; sys.path.insert(0, '$folder'); from cloudio import *; v, f = read_ply('$mesh'); "
        . "write_ply('$mesh.places', sample_mesh(xyz(v), f, 400_000, 3)[0])";
    timed(@python, '-c', $script);
    my %told = measured("$mesh.places", 0.005);
    unlink "$mesh.places";
    return %told;
}

finish('ear') if grep { wanted($_) } qw(ear_wedges ear_fandisk_120k ear_fandisk_noisy ear_fandisk_rough ear_armadillo_22k ear_armadillo_800k
    ear_igea_10k ear_mesh);
