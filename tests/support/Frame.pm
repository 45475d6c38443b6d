package Frame;

# Draco results as other programs decode them, beside our PLY of the same request. A script that uses this has Cli too.
use strict;
use warnings;
use Exporter 'import';
use FindBin;
use JSON::PP;
use POSIX qw(floor frexp);
use Test::More;
use lib "$FindBin::Bin/../cli";
use Cli;

our @EXPORT = qw(points_of ply clouds compare origin_of largest);

my $bits = 14;
my %code = (char => 'c1', uchar => 'C1', int8 => 'c1', uint8 => 'C1', short => 's<2', ushort => 'S<2', int => 'l<4',
    uint => 'L<4', float => 'f<4', float32 => 'f<4', double => 'd<8');

# The points of a binary PLY: a hash for each.
sub points_of {
    my ($path) = @_;
    my ($head, $body) = slurp($path) =~ /\A(.*?\nend_header\r?\n)(.*)\z/s or die "$path: no PLY";
    my ($n, $vertex) = $head =~ /^element vertex (\d+)\r?\n((?:property .*\n)*)/m;
    my ($template, $size, @names) = ('', 0);
    while ($vertex =~ /^property (\w+) (\w+)/mg) {
        my ($type, $name) = ($1, $2);
        my ($letters, $bytes) = $code{$type} =~ /\A(.*)(\d)\z/;
        push @names, $name;
        $template .= $letters;
        $size += $bytes;
    }
    return map { my %point; @point{@names} = unpack $template, substr $body, $_ * $size, $size; \%point } 0 .. $n - 1;
}

# A binary PLY with these properties ("double x"), of rows with a value for each.
sub ply {
    my ($properties, @rows) = @_;
    my $template = join '', map { my ($type) = split / /; $code{$type} =~ s/\d\z//r } @$properties;
    return "ply\nformat binary_little_endian 1.0\nelement vertex " . @rows . "\n"
        . join('', map { "property $_\n" } @$properties) . "end_header\n" . join '', map { pack $template, @$_ } @rows;
}

# Four clouds as files of a folder, with the origin that auto gives their results: [name, path, "X,Y,Z"]. None without
# ../shared.
sub clouds {
    my ($dir) = @_;
    my ($bunny, $autzen) = (shared('data/bunny.ply'), shared('data/autzen.ply'));
    return unless $bunny && $autzen;
    my @all = points_of($bunny);
    my @some = @all[map { 9 * $_ } 0 .. $#all / 9];
    # A bunny of 150 metres in the north of Germany, to the micrometre.
    spew("$dir/utm.ply", ply(['double x', 'double y', 'double z'],
            map { [566000.123456 + 1000 * $_->{x}, 5933000.5 + 1000 * $_->{y}, 20 + 1000 * $_->{z}] } @some));
    my @rich = map {
        my $p = $_;
        my $r = sqrt($p->{x}**2 + $p->{y}**2 + $p->{z}**2);
        my @unit = map { $p->{$_} / $r } qw(x y z);
        [@$p{qw(x y z)}, @unit, map { int(127.5 * ($_ + 1)) } @unit]
    } @some;
    spew("$dir/rich.ply", ply([map({ "float $_" } qw(x y z nx ny nz)), map { "uchar $_" } qw(red green blue)], @rich));
    return (['bunny', $bunny, '0,0,0'], ['autzen', $autzen, '636590,849217,463'], ['UTM', "$dir/utm.ply", '565983,5933111,19'],
        ['colours and normals', "$dir/rich.ply", '0,0,0']);
}

# The distance of float32 numbers from each other at x.
sub step { my ($x) = @_; return 2**((frexp(abs $x))[1] - 24) }

sub largest { my $most = 0; for (@_) { $most = abs if abs > $most } return $most }

sub extent {
    my ($axis, @points) = @_;
    my @x = sort { $a <=> $b } map { $_->{$axis} } @points;
    return $x[-1] - $x[0];
}

# The origin in a report, as the parameter has it.
sub origin_of { my ($report) = @_; return join ',', map { $report->{origin}{$_} } qw(x y z) }

# The nearest of the points that lie within `near`, which %$at has by cells of that size.
sub nearest {
    my ($p, $at, $near) = @_;
    my ($x, $y, $z) = map { floor($p->{$_} / $near) } qw(x y z);
    my ($best, $least) = (undef, 9e99);
    for my $i (0 .. 26) {
        for my $q (@{ $at->{ join ',', $x + $i % 3 - 1, $y + int($i / 3) % 3 - 1, $z + int($i / 9) - 1 } // [] }) {
            my $d = largest(map { $q->{$_} - $p->{$_} } qw(x y z));
            ($best, $least) = ($q, $d) if $d < $least;
        }
    }
    return $best;
}

# Each point of ours with the decoded one: by its place in the file or, of a file without order, by where it lies.
sub pairs {
    my ($ours, $theirs, $order, $near) = @_;
    return map { [$ours->[$_], $theirs->[$_]] } 0 .. $#$ours if $order eq 'progressive';
    my %at;
    push @{ $at{ join ',', map { floor($_ / $near) } @$_{qw(x y z)} } }, $_ for @$theirs;
    return map { [$_, nearest($_, \%at, $near)] } @$ours;
}

# Attributes that both have: colours are exact, normals have 12 bits.
sub compare_attributes {
    my ($name, @pairs) = @_;
    is scalar(grep { my ($p, $q) = @$_; grep { $p->{$_} != ($q->{$_} // -1) } qw(red green blue) } @pairs), 0,
        "$name: the colours are ours";
    cmp_ok largest(map { my ($p, $q) = @$_; map { $p->{$_} - ($q->{$_} // 9) } qw(nx ny nz) } @pairs), '<', 0.002,
        "$name: so are the normals";
}

# Resamples a cloud to Draco and to PLY, has `decode` (FILE.drc, OUT.ply) decode the former, and compares: as many points,
# positions plus origin ours within half a cell and a step of float32, attributes.
sub compare {
    my ($dir, $cloud, $order, $decode) = @_;
    my ($name, $input, $origin) = @$cloud;
    my @request = ('resample', $input, '-n', 600, '--iterations', 1, '--polish', 2, '--order', $order, '--intrinsic', 'none');
    $name .= ", $order";
    my ($code, $out, $err) = run([@request, '--quantization', $bits, '--json', '-f', '-o', "$dir/out.drc"]);
    is $code, 0, "$name: there is a Draco file" or diag $err;
    my $report = decode_json((split /\n/, $out)[-1]);
    is origin_of($report), $origin, "$name: its origin is $origin";
    is +(run([@request, '--quiet', '-f', '-o', "$dir/out.ply"]))[0], 0, "$name: there is a PLY file";
    $decode->("$dir/out.drc", "$dir/theirs.ply", $name, $origin);
    my @ours = points_of("$dir/out.ply");
    my @theirs = points_of("$dir/theirs.ply");
    is scalar @theirs, scalar @ours, "$name: as many points";
    my $step = step(largest(map { @$_{qw(x y z)} } @theirs));
    my $within = largest(map { extent($_, @theirs) } qw(x y z)) / (2**$bits - 1) / 2 + $step;
    for my $p (@theirs) { $p->{$_} += $report->{origin}{$_} for qw(x y z) }
    my @pairs = pairs(\@ours, \@theirs, $order, 4 * $within);
    my $off = largest(map { my ($p, $q) = @$_; map { $q ? $p->{$_} - $q->{$_} : 9e99 } qw(x y z) } @pairs);
    cmp_ok $off, '<=', $within, "$name: positions plus origin are ours";
    note sprintf '%s: off by %.3g, half a cell and a step are %.3g', $name, $off, $within;
    compare_attributes($name, @pairs) if exists $ours[0]{red} && exists $ours[0]{nx};
}

1;
