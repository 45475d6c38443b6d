#!/usr/bin/perl
# Double in, double out, bit for bit, where no point is moved: here and by a daemon of our own; else the loss is said.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use Test::More;

my $folder = scratch();
my $n = 1500;
my @points; # on a sphere of 50 km at a place of a map grid, with digits of micrometres
for my $i (0 .. $n - 1) {
    my $z = 1 - (2 * $i + 1) / $n;
    my ($r, $a) = (sqrt(1 - $z * $z), $i * 2.399963229728653);
    push @points, pack 'd<3', 500000.123456 + 50000 * $r * cos $a, 5000000.654321 + 50000 * $r * sin $a, -100.5 + 50000 * $z;
}
my $head = join '', "ply\nformat binary_little_endian 1.0\nelement vertex $n\n", map { "property double $_\n" } qw(x y z);
my $cloud = spew("$folder/cloud.ply", "${head}end_header\n" . join '', @points);
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);
my %known = map { $_ => 1 } @points;

# The doubles of a result, a string for each point.
sub points_of {
    my ($path) = @_;
    my $bytes = slurp($path);
    like $bytes, qr/element vertex \d+\nproperty double x\nproperty double y\nproperty double z\nend_header\n/, "of doubles";
    return unpack '(a24)*', substr $bytes, index($bytes, "end_header\n") + 11;
}

for my $where ([], ['--server', $daemon->{url}]) {
    my ($by, $out) = (@$where ? 'by a daemon' : 'here', "$folder/out.ply");
    my ($code, $stdout, $stderr) = run(['convert', $cloud, '-fo', $out, @$where]);
    is $code, 0, "doubles are converted, $by" or diag($stderr);
    unlike $stderr, qr/dropped/, "without loss, $by";
    is_deeply [points_of($out)], \@points, "and are the same, $by";

    ($code, $stdout, $stderr) = run(['denoise', $cloud, '--filters', 'outliers', '--order', 'progressive', '-fo', $out, @$where]);
    is $code, 0, "outliers are left out, $by" or diag($stderr);
    my @left = points_of($out);
    is scalar(grep { $known{$_} } @left), scalar @left, "the others stay bit for bit in another order, $by";
    cmp_ok scalar @left, '>', $n / 2, "most of them, $by";

    ($code, $stdout, $stderr) = run(['denoise', $cloud, '--filters', 'mls', '-fo', $out, @$where]);
    is $code, 0, "points are moved, $by" or diag($stderr);
    is scalar(grep { $known{$_} } points_of($out)), 0, "then none stays, $by";

    ($code, $stdout, $stderr) = run(['convert', $cloud, '--quantization', 0, '-fo', "$folder/out.drc", @$where]);
    is $code, 0, "float32 is written, $by" or diag($stderr);
    like $stderr, qr/: dropped: digits of positions \($n\)\n/, "and the loss is said, $by";
}

done_testing;
