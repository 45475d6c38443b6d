#!/usr/bin/perl
# A cloud with millimetres of detail far from zero beside the same cloud at the origin: the results, shifted back, and what
# is told of them.
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use JSON::PP;
use List::Util qw(max);
use Faults;

my %option = options();
my $binary = $ENV{VORONOID};
my $dir = tempdir(CLEANUP => 1);
my @shift = (500_000.25, 6_000_000.5, 120.125); # exact in binary, as the cloud's 2^-16 m are
my $n = $option{long} ? 200_000 : 8_000;

sub write_cloud {
    my ($path, @by) = @_;
    my ($body, $x) = ('', $option{seed});
    my $next = sub { $x = ($x * 1_103_515_245 + 12_345) & 0x7fffffff; int($x / 2) / 0x40000000 };

    for (1 .. $n) {
        my ($u, $v) = (20 * $next->(), 20 * $next->());
        my @at = map { sprintf('%.0f', $_ * 65536) / 65536 } $u, $v, 2 * sin($u / 4) * cos($v / 5) + 0.002 * $next->();
        $body .= pack 'd<3', map { $at[$_] + $by[$_] } 0 .. 2;
    }
    open my $out, '>:raw', $path or die "$path: $!";
    print {$out} "ply\nformat binary_little_endian 1.0\nelement vertex $n\n", (map { "property double $_\n" } qw(x y z)),
        "end_header\n", $body;
    close $out or die "$path: $!";
}

sub points_of {
    my ($path) = @_;
    open my $in, '<:raw', $path or die "$path: $!";
    my $bytes = do { local $/; <$in> };
    my ($head, $body) = split /end_header\n/, $bytes, 2;
    my @types = $head =~ /^property (\S+) \S+$/mg;
    my ($count) = $head =~ /^element vertex (\d+)$/m;
    my $row = join '', map { { double => 'd<', float => 'f<', uchar => 'C', int => 'l<' }->{$_} } @types;
    return [map { [@$_[0 .. 2]] } map { [unpack $row, substr $body, $_ * length(pack $row, (0) x @types)] } 0 .. $count - 1];
}

sub resample {
    my ($name) = @_;
    system($binary, 'resample', "$dir/$name.ply", '-n', $n / 4, '--quiet', '-f', '-o', "$dir/$name-out.ply") == 0 or die "$name\n";
    return points_of("$dir/$name-out.ply"), decode_json(qx{$binary measure $dir/$name-out.ply});
}

write_cloud("$dir/here.ply", 0, 0, 0);
write_cloud("$dir/there.ply", @shift);
my ($here, $here_told) = resample('here');
my ($there, $there_told) = resample('there');
my $off = max map { my $i = $_; map { abs($there->[$i][$_] - $shift[$_] - $here->[$i][$_]) } 0 .. 2 } 0 .. $#$here;
my $delta = abs($there_told->{delta} / $here_told->{delta} - 1);
my $sigma = abs($there_told->{sigma} / $here_told->{sigma} - 1);
figure('G20', "UTM and origin, $n points: results, shifted back", sprintf('%.1e m apart', $off), '<= 1e-6 m', $off <= 1e-6);
figure('G20', 'their delta as measured', sprintf('%.1e apart', $delta), '<= 1e-9', $delta <= 1e-9);
figure('G20', 'their sigma as measured', sprintf('%.1e apart', $sigma), '<= 1e-9', $sigma <= 1e-9);
