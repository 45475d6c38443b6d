#!/usr/bin/perl
# Hostile files and texts, each with the exact status and place its refusal has: how many, and how many do not.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Faults;

options();
my %table = (
    'PLY and Draco files' => [240, 'codec_files'],
    'JSON texts' => [60, 'json_read', 'json_request', 'json_values', 'spec_table'],
    'multipart bodies' => [40, 'multipart_test'],
);
my $rooms = 'build/release/tests/unit';

# A table that is one test tells how many rows it has by its source.
sub rows_of {
    my ($program) = @_;
    open my $in, '<', "tests/unit/$program.c" or die "$program.c: $!\n";
    return scalar grep { /^    \{"/ } <$in>;
}

chdir "$FindBin::Bin/../../..";
for my $what (sort keys %table) {
    my ($wanted, @programs) = @{ $table{$what} };
    my ($cases, $failed) = (0, 0);
    for my $program (@programs) {
        system("make -s $rooms/$program >&2") == 0 or die "$program cannot be made\n";
        my @lines = qx{$rooms/$program};
        my $told = grep { /^(?:not )?ok\b/ } @lines;
        my $rows = rows_of($program);
        $cases += $rows > $told ? $rows : $told;
        $failed += grep { /^not ok\b/ } @lines;
    }
    figure('G9', $what, "$cases, $failed not as said", ">= $wanted, 0", $cases >= $wanted && $failed == 0);
}
