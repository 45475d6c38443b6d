#!/usr/bin/perl
# Real scans from start to end: an aerial cloud with double coordinates, colours and labels, a laser-scanned figure
# with normals or colours, a facade. What comes out has the right number of points, all apart, on the data, with
# attributes that the input has there.
use strict;
use warnings;
use File::Temp qw(tempdir);
use JSON::PP;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use Test::More;

my $binary = $ENV{VORONOID} // 'build/release/voronoid';
my $dir = tempdir(CLEANUP => 1);

# Header of a PLY file: names and types of the vertex properties.
sub properties {
    my ($path) = @_;
    open my $in, '<:raw', $path or die "$path: $!";
    my ($in_vertex, @found);
    while (my $line = <$in>) {
        $line =~ s/\s+$//;
        $in_vertex = $1 eq 'vertex' if $line =~ /^element (\S+)/;
        push @found, "$2 $1" if $in_vertex && $line =~ /^property (\S+) (\S+)$/;
        last if $line eq 'end_header';
    }
    return @found;
}

sub measure {
    my ($result, $reference) = @_;
    return decode_json(`$binary measure $result --reference $reference`);
}

# A quarter of the points in every run, in `make soak` all of them.
sub some { return $ENV{VT_SOAK} ? $_[0] : $_[0] / 4 }

my %scan = (
    'building.ply' => { points => some(8000), keep => ['segment_index int', 'nx float'] },
    'b9_training.ply' => { points => some(4000), keep => ['x double', 'red uchar', 'label int'] },
    'hippo1.ply' => { points => some(3000), keep => ['x double', 'nz double'] },
);
for my $name (sort keys %scan) {
    my $path = `tests/demo/scan.sh $name 2>$dir/err`;
    chomp $path;
    SKIP: {
        skip "$name: its Debian package cannot be fetched here", 5 if $? != 0;
        my ($points, $keep) = @{ $scan{$name} }{qw(points keep)};
        is(system("$binary resample $path -n $points --iterations 10 --polish 40 -fo $dir/$name --quiet"), 0, "$name is resampled");
        my $even = measure("$dir/$name", $path);
        is($even->{n}, $points, "$name: the number of points asked for");
        is($even->{coincident}, 0, "$name: none share a place");
        cmp_ok($even->{input}{far_over_knn6_p999}, '<=', 2, "$name: none leaves the data");
        my %has = map { $_ => 1 } properties("$dir/$name");
        is(join(', ', grep { !$has{$_} } @$keep), '', "$name: attributes and types are carried");
    }
}

# Rough scans, resampled in haste: points over one another would be projected onto the same place. Data drew some of those that
# ear projects into one: of 2,500 of kitti 330.
for my $scan (['office1.ply', some(20000)], ['autzen.ply', some(8000)], ['kitti_000008.ply', some(5000)],
    ['kitti_000008.ply', some(5000), qw(--method ear)]) {
    my ($name, $points, @method) = @$scan;
    my $path = shared("data/$name");
    SKIP: {
        skip "$name: no ../shared/data/$name", 3 unless $path;
        my $steps = @method ? '--steps 12' : '--iterations 4';
        is(system("$binary resample $path -n $points @method $steps --polish 30 -fo $dir/$name --quiet"), 0, "$name @method is resampled");
        my $even = measure("$dir/$name", $path);
        is($even->{n}, $points, "$name @method: the number of points asked for");
        is($even->{coincident}, 0, "$name @method: none share a place");
    }
}

# A lens two and a half spacings thick faces outward, but for a few points at its rim, and a terrain with buildings and trees up.
for (['cases/blade_10k.ply', 4000, 20, 'lens'], ['data/autzen.ply', 400, 40, 'terrain']) {
    my ($name, $points, $most, $what) = @$_;
    my $path = shared($name);
    SKIP: {
        skip "no ../shared/$name", 1 unless $path;
        system("$binary resample $path -n $points --normals fit --iterations 2 --polish 4 --attributes drop -fo $dir/$what.ply --quiet");
        my ($head, $data) = split /(?<=end_header\n)/, slurp("$dir/$what.ply"), 2;
        my ($form, $bytes) = $head =~ /double/ ? ('d<3f<3', 36) : ('f<6', 24);
        my $wrong = grep { my ($z, $up) = (unpack $form, substr $data, $bytes * $_, $bytes)[2, 5];
            $what eq 'lens' ? abs $z > .006 && $z * $up < 0 : $up < 0 } 0 .. $points - 1;
        cmp_ok($wrong, '<=', $most, "the $what: so many face the wrong way");
    }
}

# A mesh's vertices, coarse but exact, and a cluttered scan: neither is taken for noisy. Which points lie on one sheet is
# asked after that, and takes the scan twenty times as long.
for my $name ('cow_mesh.ply', 'scannet.ply') {
    my $path = shared("data/$name");
    SKIP: {
        skip "$name: no ../shared/data/$name", 1 unless $path;
        like(scalar(`$binary resample $path -n 2000 --iterations 1 --polish 0 --intrinsic none -fo $dir/$name --json --quiet`),
            qr/"neighbors":20\b/, "$name: fitted closely");
    }
}
done_testing();
