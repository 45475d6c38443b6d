package Toy;

# The binary of config=toy for the tests of this room, whatever they share with others: it is used before Cli or Vt, which
# run the binary that the environment names.
use strict;
use warnings;
use Exporter 'import';
use JSON::PP;

our @EXPORT = qw(lines cloud_of positions grid far_from);
our $product;

BEGIN {
    $product = $ENV{VORONOID} // 'build/release/voronoid';
    $ENV{VORONOID} = 'build/toy/voronoid';
}

# Objects, one a line.
sub lines { return map { decode_json($_) } split /\n/, $_[0] }

# An ascii PLY of points [x, y, z, flag], where the flag is an attribute.
sub cloud_of {
    return "ply\nformat ascii 1.0\nelement vertex " . @_
        . "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar flag\nend_header\n"
        . join '', map {"@$_\n"} @_;
}

# n x n points of a plane, a quarter apart, moved by @shift; the flag marks those of the first row.
sub grid {
    my ($n, @shift) = @_;
    return map {
        my $x = $_;
        map { [$x / 4 + $shift[0], $_ / 4 + $shift[1], $shift[2], $x == 0 ? 1 : 0] } 0 .. $n - 1
    } 0 .. $n - 1;
}

# The positions of a PLY of floats, ascii or little endian, with nothing but positions in it.
sub positions {
    my ($bytes) = @_;
    my ($head, $body) = $bytes =~ /\A(ply\n.*?end_header\n)(.*)\z/s;
    return map { [split / /] } split /\n/, $body if $head =~ /^format ascii/m;
    return map { [unpack 'f<3', substr $body, 12 * $_, 12] } 0 .. length($body) / 12 - 1;
}

# How far the farthest of some points is from the nearest of others.
sub far_from {
    my ($points, $others) = @_;
    my $far = 0;
    for my $p (@$points) {
        my $near = 'inf';
        for my $o (@$others) {
            my $d = ($p->[0] - $o->[0])**2 + ($p->[1] - $o->[1])**2 + ($p->[2] - $o->[2])**2;
            $near = $d if $d < $near;
        }
        $far = $near if $near > $far;
    }
    return sqrt $far;
}

1;
