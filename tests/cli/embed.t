#!/usr/bin/perl
# The library that make install copies: a program that is built with pkg-config alone and links Draco's decoder and ours has the
# points of voronoid restore, with the shared library and with the static one; and what the library exports is what is kept in
# tests/embed/abi.txt. Who changes that on purpose changes the number in the library's name, too.
use strict;
use warnings;
use File::Temp qw(tempdir);
use Test::More;

my $binary = $ENV{VORONOID} // 'build/release/voronoid';
my ($config) = $binary =~ m{(?:^|/)build/(release|debug)/voronoid\z} or plan skip_all => 'the binary is not one that is installed';
my $folder = tempdir(CLEANUP => 1);
my $root = "$folder/root";
my $flags = "PKG_CONFIG_PATH=$root/lib/pkgconfig pkg-config --cflags --libs";

sub runs {
    my ($what, $command) = @_;
    my $ok = is system("{ $command; } >$folder/log 2>&1"), 0, $what;
    diag slurp("$folder/log") if !$ok;
    return $ok;
}

sub slurp {
    my ($path) = @_;
    open my $in, '<:raw', $path or return '';
    local $/;
    return scalar <$in>;
}

runs('make install', "make -s config=$config install PREFIX=$root") or BAIL_OUT('no library');

# A torus of 3,000 points, coded.
my @points = map { [(3 + cos 0.7 * $_) * cos(0.013 * $_), (3 + cos 0.7 * $_) * sin(0.013 * $_), sin 0.7 * $_] } 1 .. 3000;
open my $ply, '>', "$folder/torus.ply" or die "$folder: $!\n";
print $ply "ply\nformat ascii 1.0\nelement vertex 3000\n", map({ "property float $_\n" } qw(x y z)), "end_header\n", map { "@$_\n" } @points;
close $ply;
runs('a cloud is coded', "$binary convert $folder/torus.ply --quantization 7 -o $folder/torus.drc");
runs('and restored by the command', "$binary restore $folder/torus.drc -o $folder/restored.ply");
my $wanted = slurp("$folder/restored.ply") =~ s/.*?end_header\n//sr;
is length $wanted, 36_000, 'to as many points';

my %how = (
    shared => "c++ -std=c++17 tests/embed/embed.cc -o $folder/shared \$($flags voronoid draco) -Wl,-rpath,$root/lib",
    static => "rm $root/lib/libvoronoid.so && c++ -std=c++17 tests/embed/embed.cc -o $folder/static \$($flags --static voronoid draco)",
);
for my $how (sort keys %how) {
    runs("the example is built with the $how library", $how{$how});
    runs('and runs', "$folder/$how $folder/torus.drc >$folder/points");
    ok slurp("$folder/points") eq $wanted, 'and has the points of the command, bit for bit';
    is scalar(() = `ldd $folder/$how` =~ /sqlite|microhttpd|cjson|seccomp|curl|nettle/g), 0, 'without what the daemon needs';
}
isnt system("$folder/shared $folder/torus.ply >$folder/points 2>/dev/null"), 0, 'what is no Draco cloud fails';

my @kept = split /\n/, slurp('tests/embed/abi.txt');
my @exported = sort map { (split)[2] } grep { / [A-Z] / } split /\n/, `nm -D --defined-only $root/lib/libvoronoid.so.0`;
my @defined = sort map { (split)[2] } grep { / [A-Z] / } split /\n/, `nm -g --defined-only $root/lib/libvoronoid.a`;
is_deeply \@exported, [grep { !/ / } @kept], 'the shared library exports what is kept';
is_deeply \@defined, \@exported, 'and the static one the same';
open my $sizes, '>', "$folder/sizes.c" or die "$folder: $!\n";
print $sizes "#include <voronoid.h>\n", map { /^(struct \w+) (\d+)$/ ? "_Static_assert(sizeof($1) == $2, \"$1\");\n" : () } @kept;
close $sizes;
runs('structs have the sizes that are kept', "cc -std=c11 -Wall -Werror -pedantic -c $folder/sizes.c -o $folder/sizes.o \$($flags voronoid)");
done_testing;
