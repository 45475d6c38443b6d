#!/usr/bin/perl
# usage: apart.pl NAME A B [BITS]: compares what decode.c printed on two machines, prints a line about it, and fails if they
# are further apart than they may be.
#   without BITS  the same file, read by both: positions within one float32 step of the largest, attributes within two of
#                 theirs (normals are made of two quantised numbers); colours are whole numbers, and so the same
#   with BITS     a file of each, in any order: every point lies within one cell of a point of the other file, along each
#                 axis; a cell is the longest side of the points' box by 2^BITS - 1
use strict;
use warnings;
use List::Util qw(max min);
use POSIX qw(floor strtod);

my ($name, $one, $other, $bits) = @ARGV;

sub read_points {
    my ($path) = @_;
    open my $in, '<', $path or die "$path: $!";
    my ($origin, @rows) = <$in>;
    close $in;
    defined $origin or die "$path is empty\n";
    return ($origin, map { [split] } @rows);
}

sub numbers {
    my ($row, @columns) = @_;
    return map { (strtod($_))[0] } @$row[@columns];
}

sub position { return numbers($_[0], 0 .. 2) }

# Rows that differ in these columns, and by how many float32 steps of the largest number in them at most.
sub steps_apart {
    my ($here, $there, @columns) = @_;
    my ($moved, $farthest, $largest) = (0, 0, 0);
    for my $i (0 .. $#$here) {
        my @x = numbers($here->[$i], @columns);
        my @y = numbers($there->[$i], @columns);
        my $apart = max(map { abs($x[$_] - $y[$_]) } 0 .. $#x);
        $moved++ if $apart > 0;
        $farthest = max($farthest, $apart);
        $largest = max($largest, map { abs } @x);
    }
    my $step = $largest > 0 ? 2**(floor(log($largest) / log 2) - 23) : 1;
    return ($moved, $farthest / $step);
}

# Points of one side that no point of the other is within a cell of.
sub lonely {
    my ($here, $there, $cell) = @_;
    my (%in, $lonely);
    for my $row (@$there) {
        my @x = position($row);
        push @{ $in{ join ' ', map { floor($_ / $cell) } @x } }, \@x;
    }
    $lonely = 0;
    for my $row (@$here) {
        my @x = position($row);
        my @at = map { floor($_ / $cell) } @x;
        my $found = 0;
        for my $k (0 .. 26) {
            my @by = ($at[0] + $k % 3 - 1, $at[1] + int($k / 3) % 3 - 1, $at[2] + int($k / 9) - 1);
            for my $y (@{ $in{"@by"} // [] }) {
                $found ||= max(map { abs($x[$_] - $y->[$_]) } 0 .. 2) <= $cell;
            }
        }
        $lonely++ if !$found;
    }
    return $lonely;
}

sub longest_side {
    my ($rows) = @_;
    my @at = map { [position($_)] } @$rows;
    return max(map { my $c = $_; max(map { $_->[$c] } @at) - min(map { $_->[$c] } @at) } 0 .. 2);
}

my ($here_origin, @here) = read_points($one);
my ($there_origin, @there) = read_points($other);
my $failed = $here_origin ne $there_origin || @here != @there || @here == 0;
if ($failed) {
    printf "%s: FAILED: %d and %d points, origins %s and %s\n", $name, scalar @here, scalar @there,
        map { s/\n//r } $here_origin, $there_origin;
} elsif (defined $bits) {
    # Coordinates are rounded to float32 after the cell.
    my $cell = longest_side(\@here) / (2**$bits - 1) * (1 + 1e-3);
    my $lonely = lonely(\@here, \@there, $cell) + lonely(\@there, \@here, $cell);
    $failed = $lonely > 0;
    printf "%s: other bytes, %d of %d points further than a cell from the other's%s\n", $name, $lonely, 2 * @here,
        $failed ? ': FAILED' : '';
} else {
    my ($moved, $steps) = steps_apart(\@here, \@there, 0 .. 2);
    printf "%s: %d of %d points differ, by at most %g float32 steps", $name, $moved, scalar @here, $steps;
    $failed = $steps > 1;
    if (@{ $here[0] } > 3) {
        ($moved, $steps) = steps_apart(\@here, \@there, 3 .. $#{ $here[0] });
        printf "; attributes of %d, by at most %g", $moved, $steps;
        $failed ||= $steps > 2;
    }
    print $failed ? ": FAILED\n" : "\n";
}
exit $failed;
