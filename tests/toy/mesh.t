#!/usr/bin/perl
# A result with faces, of a process that only the tables of config=toy know: written on the command line, served over
# HTTP, converted there, and read again by us and by Debian's draco_decoder.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin, "$FindBin::Bin/../cli", "$FindBin::Bin/../support";
use Toy;
use Cli qw(run scratch spew slurp leftovers);
use JSON::PP;
use Test::More;
use Vt;

my $dir = scratch();
my $length = 60;
my @points = map { [$_ % 2, int($_ / 2), $_ % 7 / 4, $_ % 2] } 0 .. 2 * $length - 1;
my $cloud = cloud_of(@points);
my $in = spew("$dir/in.ply", $cloud);
my %width = (char => 1, uchar => 1, short => 2, ushort => 2, int => 4, uint => 4, float => 4, double => 8,
    int8 => 1, uint8 => 1, int16 => 2, uint16 => 2, int32 => 4, uint32 => 4, float32 => 4, float64 => 8);

# Vertices [x, y, z] and faces [i, j, k] of a little-endian PLY whose first properties are floats x y z, as we and
# draco_decoder write them.
sub mesh_of {
    my ($bytes) = @_;
    my ($head, $body) = $bytes =~ /\A(ply\n.*?end_header\n)(.*)\z/s or die 'no PLY';
    my ($vertices) = $head =~ /^element vertex (\d+)$/m;
    my ($faces) = $head =~ /^element face (\d+)$/m;
    my ($listed) = $head =~ /^element vertex \d+\n((?:property \w+ \w+\n)+)/m;
    my $row = 0;
    $row += $width{$_} for $listed =~ /^property (\w+) /mg;
    my @vertices = map { [unpack 'f<3', substr $body, $row * $_, 12] } 0 .. $vertices - 1;
    my @faces = map { [unpack 'C V3', substr $body, $row * $vertices + 13 * $_, 13] } 0 .. ($faces // 0) - 1;
    is scalar(grep { shift(@$_) != 3 } @faces), 0, 'every face is a triangle';
    is length($body), $row * $vertices + 13 * @faces, 'and nothing stands behind them';
    return \@vertices, \@faces;
}

# The triangles by the places of their corners, to a quarter, whatever the order of points, faces and corners, but for
# the side that they face.
sub triangles {
    my ($vertices, $faces) = @_;
    my @names = map {
        join ',', map { sprintf '%.2f', (sprintf '%.0f', 4 * $_) / 4 } @$_[0 .. 2]
    } @$vertices;
    return sort map {
        my @corner = @names[@$_];
        push @corner, shift @corner while $corner[0] gt $corner[1] || $corner[0] gt $corner[2];
        "@corner";
    } @$faces;
}

my @wanted = triangles(\@points, [map { $_ % 2 ? [$_, $_ + 2, $_ + 1] : [$_, $_ + 1, $_ + 2] } 0 .. @points - 3]);
is scalar(@wanted), 2 * $length - 2, 'there is something to look for';

sub has_mesh {
    my ($bytes, $name) = @_;
    my ($vertices, $faces) = mesh_of($bytes);
    is scalar(@$vertices), @points, "$name: every point";
    return is_deeply [triangles($vertices, $faces)], \@wanted, "$name: every triangle, over its points";
}

# What another program makes of a Draco file.
my $has_decoder = $ENV{CI} || system('command -v draco_decoder >/dev/null') == 0;

sub is_draco_mesh {
    my ($bytes, $name) = @_;
    my $file = spew("$dir/decode.drc", $bytes);
    is join(' ', unpack 'x7 C', $bytes), '1', "$name: it is a mesh";
SKIP: {
        skip 'draco_decoder (Debian package draco) is not installed', 1 unless $has_decoder;
        is system("draco_decoder -i $file -o $dir/decoded.ply >$dir/log 2>&1"), 0, "$name: draco_decoder decodes it"
            or diag slurp("$dir/log");
        has_mesh(slurp("$dir/decoded.ply"), $name);
    }
    return;
}

subtest 'on the command line' => sub {
    my ($code, undef, $stderr) = run(['ribbon', $in, '-o', "$dir/here.ply"]);
    is $code, 0, 'PLY is written' or diag $stderr;
    my $ply = slurp("$dir/here.ply");
    like $ply, qr/^property uchar flag\nelement face 118\nproperty list uchar int vertex_indices\nend_header\n/m, 'with its faces';
    has_mesh($ply, 'PLY');
    for my $case ([], ['--quantization', 0], ['--quantization', 14, '--compression', 10], ['--compression', 0]) {
        my $name = "Draco @$case";
        ($code, undef, $stderr) = run(['ribbon', $in, '-o', "$dir/here.drc", @$case]);
        is $code, 0, "$name is written" or diag $stderr;
        is_draco_mesh(slurp("$dir/here.drc"), $name);
    }
    ($code) = run(['ribbon', spew("$dir/two.ply", cloud_of(@points[0, 1])), '-o', "$dir/two.out.ply"]);
    is $code, 0, 'two points are a result';
    unlike slurp("$dir/two.out.ply"), qr/^element face/m, 'without faces';
};

subtest 'what is read of it' => sub {
    for my $file ("$dir/here.ply", "$dir/here.drc") {
        my ($code, $stdout) = run(['measure', $file, '--reference', $in, '--json']);
        is $code, 0, "$file is measured";
        my $measured = decode_json($stdout);
        is $measured->{n}, 120, 'all of its points';
        cmp_ok $measured->{input}{hausdorff}, '<', 0.01, 'where they were';
        ($code, $stdout) = run(['inspect', $file, '--json']);
        is decode_json($stdout)->{points}{all}, 120, "$file is inspected";
        my (undef, $told, $stderr) = run(['convert', $file, '-o', "$dir/points.ply", '--json']);
        is_deeply [grep { $_->{what} eq 'face' } @{ (lines($told))[-1]{dropped} }], [{ what => 'face', count => 118 }],
            'convert says that it drops its faces';
        unlike slurp("$dir/points.ply"), qr/^element face/m, 'and does';
    }
};

subtest 'over HTTP' => sub {
    my $daemon = Vt->start;
    for my $format ('ply', 'drc') {
        my $other = $format eq 'ply' ? 'drc' : 'ply';
        my $answer = $daemon->post("/v1/processes/ribbon/execution?format=$format", $cloud, Prefer => 'respond-async');
        is $answer->{status}, 201, "$format is accepted" or diag $answer->{content};
        my $url = '/v1/jobs/' . json($answer)->{jobID};
        wait_until(sub { json($daemon->get($url))->{status} eq 'successful' }, 30);
        my %bytes = map { $_ => $daemon->get("$url/results/cloud?format=$_")->{content} } $format, $other;
        has_mesh($bytes{ply}, "the PLY of a job of $format");
        is_draco_mesh($bytes{drc}, "the Draco file of a job of $format");
        ok $bytes{$format} eq $daemon->get("$url/results/cloud")->{content}, 'the format need not be said';
    }
    my $in_one = $daemon->post('/v1/ribbon?format=ply', $cloud);
    is $in_one->{status}, 200, 'the answer to the request itself';
    has_mesh($in_one->{content}, 'it');
    my ($code) = run(['ribbon', $in, '--server', $daemon->{url}, '-o', "$dir/there.drc"]);
    is $code, 0, 'a daemon is asked from the command line';
    run(['ribbon', $in, '-o', "$dir/here.drc"]);
    ok slurp("$dir/there.drc") eq slurp("$dir/here.drc"), 'the file is the one that is made here';
    undef $daemon;
};

is leftovers($dir, qw(in.ply here.ply here.drc two.ply two.out.ply points.ply there.drc decode.drc decoded.ply log)), '',
    'nothing is left behind';
done_testing;
