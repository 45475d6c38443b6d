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
    near $got->{cells}{eta}, 3 * sqrt(3) / 5 - 1, 'eta of squares';
    near $got->{cells}{gap}, sqrt(sqrt(3)) / 2, 'gap of squares';
    is "$got->{cells}{open} $got->{six_share}", '16 0', 'cells along the border are left out; the others have four sides';
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

# The second plane is the first one moved by 0.25 along its normal; its points are one apart.
subtest 'errors against a reference' => sub {
    my @grid = map { my $x = $_; map { [$x, $_, 0] } 0 .. 4 } 0 .. 4;
    my @moved = map { [$_->[0] + 0.125, $_->[1], 0.25] } @grid;
    my @pair = (cloud('moved.ply', @moved), '--reference', cloud('plane.ply', @grid));
    my ($code, $stdout, $stderr) = run(['measure', @pair]);
    my $got = decode_json($stdout)->{input};
    my $d1 = 0.125 ** 2 + 0.25 ** 2;
    is "$code$stderr", '0', 'all is well';
    near $got->{d1_mse}, $d1, 'd1_mse';
    near $got->{d2_mse}, 0.0625, 'd2_mse';
    near $got->{peak}, 1, 'peak';
    near $got->{d1_psnr}, 10 * log(3 / $d1) / log(10), 'd1_psnr';
    near $got->{d2_psnr}, 10 * log(48) / log(10), 'd2_psnr';
    near $got->{$_}, sqrt($d1), $_ for qw(out_to_ref_rms ref_to_out_rms hausdorff);
    near $got->{chamfer}, 2 * sqrt($d1), 'chamfer';
    near $got->{hausdorff_relative}, sqrt($d1 / 32), 'hausdorff_relative';
    my (undef, $twice) = run(['measure', @pair, '--peak', '2.0e0']);
    my $other = decode_json($twice)->{input};
    near $other->{peak}, 2, 'the peak given';
    near $other->{$_} - $got->{$_}, 20 * log(2) / log(10), "twice the peak, $_" for qw(d1_psnr d2_psnr);
    near $other->{$_}, $got->{$_}, "twice the peak, $_" for qw(d1_mse d2_mse hausdorff chamfer);
    is((run(['measure', @pair, "--threads=$_"]))[1], $stdout, "$_ threads print the same") for 1, 2, 3, 8;
};

subtest 'a cloud against itself' => sub {
    my ($code, $stdout) = run(['measure', "$folder/plane.ply", '--reference', "$folder/plane.ply"]);
    my $got = decode_json($stdout)->{input};
    is $code, 0, 'all is well';
    is $got->{$_}, 0, $_ for qw(d1_mse d2_mse hausdorff chamfer);
    ok exists $got->{$_} && !defined $got->{$_}, "$_ is null" for qw(d1_psnr d2_psnr);
};

# Normals of the reference are used as they are: here they lie in the plane.
subtest 'carried normals' => sub {
    my $path = spew("$folder/normals.ply", "ply\nformat ascii 1.0\nelement vertex 25\n"
            . join('', map {"property float $_\n"} qw(x y z nx ny nz)) . "end_header\n"
            . join '', map { my $x = $_; map {"$x $_ 0 1 0 0\n"} 0 .. 4 } 0 .. 4);
    my (undef, $stdout) = run(['measure', "$folder/moved.ply", '--reference', $path]);
    near decode_json($stdout)->{input}{d2_mse}, 0.125 ** 2, 'd2_mse';
};

subtest 'a peak that is none' => sub {
    my @pair = ("$folder/moved.ply", '--reference', "$folder/plane.ply");
    for my $value (0, -1, '1e-31', '1e31', 'nan', 'inf', '0x10', '1 ', ' 1', '1,5', 'much', '1e', '--1') {
        my ($code, $stdout, $stderr) = run(['measure', @pair, "--peak=$value"]);
        my $shown = quotemeta $value;
        is "$code$stdout", '2', "'$value' is a usage error";
        like $stderr, qr/\Avoronoid: measure: peak is [^\n]*$shown[^\n]*, want a number from 1e-30 to 1e\+30 or auto\n\z/,
            "'$value' is named";
    }
    my ($code, $stdout, $stderr) = run(['measure', @pair, '--peak=']);
    is "$code$stdout$stderr", "2voronoid: measure: peak is empty, want a number from 1e-30 to 1e+30 or auto\n", 'nothing';
    ($code, $stdout, $stderr) = run(['measure', $pair[0], '--peak', 1023]);
    is "$code$stdout$stderr",
        "2voronoid: measure: the parameter peak is 1023, which needs a reference cloud, but the request has none: give --reference FILE too\n", 'no reference';
    my (undef, $default) = run(['measure', @pair]);
    is((run(['measure', @pair, '--peak=auto']))[1], $default, 'auto is the default');
    is +(run(['measure', $pair[0], '--peak=auto']))[0], 0, 'and means nothing without a reference';
};

subtest 'a document goes where it is sent' => sub {
    my ($code, $stdout) = run(['measure', "$folder/grid.ply"]);
    is slurp("$folder/grid.ply") =~ /^element vertex (\d+)$/m ? $1 : 0, decode_json($stdout)->{n}, 'it is printed';
    is +(run(['measure', "$folder/grid.ply", '-fo', '-']))[1], $stdout, 'or printed on request';
    my ($got, $printed, $errors) = run(['measure', "$folder/grid.ply", '-fo', "$folder/measure.json"]);
    is "$got$printed$errors", '0', 'or written, without a word';
    is slurp("$folder/measure.json"), $stdout, 'the same bytes';
    ($got, $printed, $errors) = run(['measure', "$folder/grid.ply", '-fo', "$folder/no/measure.json"]);
    is "$got$printed$errors", "1voronoid: $folder/no/measure.json: cannot be written: No such file or directory\n",
        'or refused before it is made';
    ($got, $printed, $errors) = run(['measure', "$folder/grid.ply", '--json', '--quiet']);
    is "$got$printed$errors", "0$stdout", 'lines of a run without records are none';
    is +(run(['measure', "$folder/grid.ply"], env => { VORONOID_SERVER => 'http://127.0.0.1:1' }))[0], 5,
        'a daemon in the environment is asked';
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

# What the yardstick knows; the rest is ours alone. Its distances are over the diagonal of the reference.
sub compare {
    my ($ours, $theirs, $path) = @_;
    my $scale = $ours->{hausdorff} ? $ours->{hausdorff_relative} / $ours->{hausdorff} : 1;
    is join(' ', grep { !exists $ours->{$_} } sort keys %$theirs), '', "$path has the yardstick's members";
    for my $key (sort keys %$theirs) {
        ref $theirs->{$key} ? compare($ours->{$key}, $theirs->{$key}, "$path.$key")
            : near($ours->{$key} * ($key =~ /_to_/ ? $scale : 1), $theirs->{$key}, "$path.$key");
    }
}

SKIP: {
    my $metrics = shared('yardstick/metrics.py');
    skip 'measure agrees with the yardstick: no ../shared/yardstick/metrics.py', 1 unless $metrics;
    my @python = ('/usr/bin/python3', $metrics);
    skip 'measure agrees with the yardstick: no numpy and scipy', 1
        if !$ENV{CI} && system('/usr/bin/python3 -c "import numpy, scipy" 2>/dev/null') != 0;
    my $a = spew("$folder/a.ply", sphere(3000, 1));
    my $b = spew("$folder/b.ply", sphere(4000, 2));
    run(['resample', $b, '-n', 1000, '--iterations', 5, '-q', '-fo', "$folder/c.ply"]);
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
