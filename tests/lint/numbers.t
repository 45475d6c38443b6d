#!/usr/bin/perl
# How many named numbers steer what the engine makes of points. Each needs a reason, and most were tuned: so they only become
# fewer. A number that sizes a task, a buffer or a message, that only tells rows apart, or that geometry gives (sides, a hexagon's height), moves no point.
use strict;
use warnings;
use Test::More;

my $most = 380; # lower it with those that go

my @rooms = map { "core/$_" } qw(align geom input seeds opt cvt kmeans lop mesh remesh);
my $no_point = qr/(?:^|_)(?:BLOCK|STREAM|SIZE|BATCH|QUOTED|NAMES|SUFFIX|NONE|PI|RADIANS|RECORDS|RECORD_EVERY|POLL_EVERY|CHUNK|TOLD|VALUES|TERMS|ORDER|BUCKETS|NOWHERE|SLOTS|AT_A_TIME|UNKNOWN|WAITS|LATER|EMPTY|OCTANTS|ROOM_FIRST|POLLED|SPAN_TURNS|PATCH_HEXAGON|PATCH_OCTAGON|LANES|HEXAGON_HEIGHT|BINS|BITS|ENTRIES|CELLS_MAX|UNKNOWNS|BOTH)(?:_|$)/;

my $directions = qr/corner|octagon|turn|^[uv]p$|lower/; # tables of unit vectors, powers and bits

# Names that have a number as their value, by #define or in an enum that gives some of its names one, and the numbers of tables, but
# for 0 and 1.
sub numbers {
    my ($path) = @_;
    open my $in, '<', $path or die "$path: $!\n";
    my $text = do { local $/; <$in> };
    $text =~ s{/\*.*?\*/}{ }gs;
    my $number = qr/[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?[FfUuLl]*/i;
    my $value = qr/\(?$number(?:[ ]*(?:<<|[-+*\/])[ ]*$number)*\)?/; # or an expression of nothing but numbers
    my @found = $text =~ /^#define[ ]+([A-Z][A-Z0-9_]+)[ ]+$value[ ]*$/mg;
    while ($text =~ /\benum\s*\w*\s*\{([^}]*)\}/g) {
        my $body = $1;
        push @found, $body =~ /\b([A-Z][A-Z0-9_]+)\s*=\s*(?!1 << [01]\b)$value\s*(?=,|\z)/g; # but for flags
    }
    @found = grep { !/$no_point/ } @found;
    while ($text =~ /\bstatic const (?!char)(?:struct \{[^}]*\} )?[^;()={}]*?(\w+)((?:\[[^\]]*\])*) = (\{[^;]*\});/g) {
        my ($name, $body) = ($1, $3);
        next if $name =~ $directions;
        push @found, map { "$name $_" } grep { !/^[01](?:\.0)?$/ } $body =~ /(?<![\w.])($number)(?!\w)/g;
    }
    return map { "$path $_" } @found;
}

my @found = map { numbers($_) } grep { -f } split /\n/, `git ls-files @rooms`;
diag $_ for $ENV{VOR_NUMBERS} ? @found : ();
cmp_ok scalar @found, '>', 100, 'numbers are found';
cmp_ok scalar @found, '<=', $most, 'no more numbers steer geometry than there were';
done_testing;
