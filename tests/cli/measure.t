#!/usr/bin/perl
# voronoid measure against clouds whose answer is known, and against the yardstick.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use JSON::PP;
use Test::More;

my $folder = scratch();

sub cloud {
    my ($name, @points) = @_;
    return spew("$folder/$name", "ply\nformat ascii 1.0\nelement vertex " . @points
            . "\nproperty double x\nproperty double y\nproperty double z\nend_header\n"
            . join '', map {"@$_\n"} @points);
}

sub near {
    my ($got, $wanted, $name) = @_;
    return cmp_ok abs($got - $wanted), '<=', 1e-6 * abs($wanted) + 1e-12, $name;
}

subtest 'a full grid is perfectly even' => sub {
    my @grid = map { my $x = $_; map { [$x, $_, 0] } 0 .. 4 } 0 .. 4;
    my ($code, $stdout, $stderr) = run(['measure', cloud('grid.ply', @grid)]);
    my $got = decode_json($stdout);
    is "$code$stderr", '0', 'all is well';
    is $got->{n}, 25, 'n';
    is $got->{coincident}, 0, 'coincident';
    near $got->{delta}, 0, 'delta';
    near $got->{sigma}, 0, 'sigma';
    near $got->{epsilon}, 1, 'epsilon';
    near $got->{$_}, 1, $_ for qw(mean_nn min_over_mean max_over_mean);
    ok !exists $got->{input}, 'no reference, no distances';
    my (undef, $piped) = run(['measure', '-'], stdin => "$folder/grid.ply");
    is $piped, $stdout, 'stdin is the same';
    my (undef, $threads) = run(['measure', "$folder/grid.ply", '--threads=3']);
    is $threads, $stdout, 'so are three threads';
};

subtest 'three points on a line' => sub {
    my ($code, $stdout) = run(['measure', cloud('line.ply', [0, 0, 0], [1, 0, 0], [3, 0, 0])]);
    my $got = decode_json($stdout);
    near $got->{mean_nn}, 4 / 3, 'mean_nn';
    near $got->{delta}, sqrt(2) / 4, 'delta';
    near $got->{sigma}, 4 / 9, 'sigma';
    near $got->{epsilon}, 1 / sqrt(1 + 1 / 8), 'epsilon';
    near $got->{max_over_mean}, 1.5, 'max_over_mean';
};

subtest 'refusals' => sub {
    for my $case (['one point', [[1, 2, 3]], 3], ['one place', [[1, 2, 3], [1, 2, 3]], 3]) {
        my ($name, $points, $wanted) = @$case;
        my $path = cloud('bad.ply', @$points);
        my ($code, $stdout, $stderr) = run(['measure', $path]);
        is $code, $wanted, "$name is rejected";
        is $stdout, '', 'nothing is printed';
        like $stderr, qr/\Avoronoid: \Q$path\E: [^\n]+\n\z/, 'it says why in one line';
    }
    my ($code, undef, $stderr) = run(['measure', "$folder/grid.ply", '--reference', "$folder/no.ply"]);
    is "$code $stderr", "1 voronoid: $folder/no.ply: cannot be read: No such file or directory\n",
        'a reference that is not there is named';
};

sub compare {
    my ($ours, $theirs, $path) = @_;
    is join(' ', sort keys %$ours), join(' ', sort keys %$theirs), "$path has the same members";
    for my $key (sort keys %$theirs) {
        ref $theirs->{$key} ? compare($ours->{$key}, $theirs->{$key}, "$path.$key")
            : near($ours->{$key}, $theirs->{$key}, "$path.$key");
    }
}

SKIP: {
    my $metrics = shared('yardstick/metrics.py');
    skip 'measure agrees with the yardstick: no ../shared/yardstick/metrics.py', 1 unless $metrics;
    my @python = ('/usr/bin/python3', $metrics);
    skip 'measure agrees with the yardstick: no numpy and scipy', 1
        if system('/usr/bin/python3 -c "import numpy, scipy" 2>/dev/null') != 0;
    my $a = spew("$folder/a.ply", sphere(3000, 1));
    my $b = spew("$folder/b.ply", sphere(4000, 2));
    run(['resample', $b, '-n', 1000, '--iterations', 5, '-q', '-o', "$folder/c.ply"]);
    my $far = cloud('far.ply', map { [500000.25 + $_ * $_ % 97 / 10, 4000000.5 + $_ * 31 % 89 / 10, $_ % 7] } 1 .. 500);
    for my $case (['scattered', $a, $b], ['resampled', "$folder/c.ply", $b], ['far away', $far, $far]) {
        my ($name, $cloud, $reference) = @$case;
        my (undef, $ours) = run(['measure', $cloud, '--reference', $reference]);
        open my $pipe, '-|', @python, $cloud, '--input', $reference or die;
        my $theirs = do { local $/; <$pipe> };
        subtest "measure agrees with the yardstick: $name" => sub {
            compare(decode_json($ours), decode_json($theirs), 'measure');
        };
    }
}

done_testing;
