#!/usr/bin/perl
# usage: picture.pl BEFORE.ply AFTER.ply OUT.png: draws both clouds side by side, seen from a corner above, near points dark. The
# files are binary, little endian. Perl's base alone: the PNG is not compressed.
use strict;
use warnings;

my ($SIDE, $GAP, $RADIUS) = (480, 12, 1.3); # pixels
my %letter = (char => 'c', uchar => 'C', short => 's<', ushort => 'S<', int => 'l<', uint => 'L<', float => 'f<', double => 'd<');
my %size = (char => 1, uchar => 1, short => 2, ushort => 2, int => 4, uint => 4, float => 4, double => 8);

# Points as [right, up, near].
sub read_points {
    my ($path) = @_;
    open my $file, '<:raw', $path or die "$path: $!\n";
    my $bytes = do { local $/; <$file> };
    my ($head, $body) = split /^end_header\n/m, $bytes, 2;
    $head =~ /^format binary_little_endian/m or die "$path: not binary, little endian\n";
    my ($n, $fields) = $head =~ /^element vertex (\d+)\n((?:property \w+ .*\n)+)/m or die "$path: no points\n";
    my ($row, %at) = 0;
    for ($fields =~ /^property (\w+ .*)$/mg) {
        my ($type, $name) = split / /, $_, 2;
        $at{$name} = [$row, $letter{$type}];
        $row += $size{$type};
    }
    my @points;
    for my $i (0 .. $n - 1) {
        my ($x, $y, $z) = map { unpack "\@$at{$_}[0] $at{$_}[1]", substr $body, $i * $row, $row } qw(x y z);
        push @points, [0.8 * $x - 0.6 * $y, 0.3 * $x + 0.4 * $y + 0.866 * $z, 0.5 * $z - 0.52 * $x - 0.69 * $y];
    }
    return \@points;
}

# Rows of grey bytes; low, high: the box that is fitted into the panel.
sub draw {
    my ($points, $low, $high) = @_;
    my @rows = map { "\xff" x $SIDE } 1 .. $SIDE;
    my $scale = ($SIDE - 20) / ((sort { $b <=> $a } map { $high->[$_] - $low->[$_] } 0, 1)[0] || 1);
    my $reach = int($RADIUS + 1);
    for my $point (sort { $a->[2] <=> $b->[2] } @$points) {
        my ($column, $row) = map { ($point->[$_] - ($low->[$_] + $high->[$_]) / 2) * $scale } 0, 1;
        ($column, $row) = ($SIDE / 2 + $column, $SIDE / 2 - $row);
        my $grey = chr int 180 - 150 * ($point->[2] - $low->[2]) / (($high->[2] - $low->[2]) || 1);
        for my $r (int($row) - $reach .. int($row) + $reach) {
            for my $c (int($column) - $reach .. int($column) + $reach) {
                next if $r < 0 || $r >= $SIDE || $c < 0 || $c >= $SIDE || ($r + 0.5 - $row)**2 + ($c + 0.5 - $column)**2 > $RADIUS**2;
                substr $rows[$r], $c, 1, $grey;
            }
        }
    }
    return \@rows;
}

my @table = map { my $c = $_; $c = $c & 1 ? 0xedb88320 ^ ($c >> 1) : $c >> 1 for 1 .. 8; $c } 0 .. 255;
sub chunk {
    my ($kind, $data) = @_;
    my $crc = 0xffffffff;
    $crc = $table[($crc ^ $_) & 255] ^ ($crc >> 8) for unpack 'C*', $kind . $data;
    return pack('N', length $data) . $kind . $data . pack 'N', $crc ^ 0xffffffff;
}

# A zlib stream of stored blocks.
sub stored {
    my ($data) = @_;
    my ($one, $two, $out) = (1, 0, "\x78\x01");
    for (unpack 'C*', $data) { $one = ($one + $_) % 65521; $two = ($two + $one) % 65521 }
    my @blocks = unpack '(a65535)*', $data;
    $out .= pack('Cvv', $_ == $#blocks, length $blocks[$_], 65535 - length $blocks[$_]) . $blocks[$_] for 0 .. $#blocks;
    return $out . pack 'N', $two << 16 | $one;
}

my ($before, $after) = map { read_points($_) } @ARGV[0, 1];
my (@low, @high);
for my $axis (0 .. 2) {
    my @sorted = sort { $a <=> $b } map { $_->[$axis] } @$before;
    ($low[$axis], $high[$axis]) = @sorted[0, -1];
}
my ($left, $right) = map { draw($_, \@low, \@high) } $before, $after;
my $image = join '', map { "\0" . $left->[$_] . "\xff" x $GAP . $right->[$_] } 0 .. $SIDE - 1;
open my $out, '>:raw', $ARGV[2] or die "$ARGV[2]: $!\n";
print $out "\x89PNG\r\n\x1a\n", chunk('IHDR', pack 'NNC5', 2 * $SIDE + $GAP, $SIDE, 8, 0, 0, 0, 0), chunk('IDAT', stored($image)), chunk('IEND', '');
close $out or die "$ARGV[2]: $!\n";
