#!/usr/bin/perl
# usage: codec.pl VORONOID OUTDIR: what denoising gains after a codec: 60,000 points of a mesh through Draco at 6 to 10 bits a
# coordinate, decoded, and denoised to as many points; and the bytes with which decoding alone is as near to the mesh. Writes
# OUTDIR/codec.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;

my $points = 60_000;
my @bits = 6 .. 10;   # of the table
my @finer = 11 .. 14; # where decoding alone gets as near
my $out = begin('Codec');
my ($folder) = yardstick() =~ m{^(.*)/};

sub must {
    my (@command) = @_;
    open my $from, '-|', @command or die "$command[0]: $!\n";
    my @lines = <$from>;
    close $from or die "@command: failed\n";
    return @lines;
}

sub python { return must('/usr/bin/python3', 'tests/by_hand/bench/codec.py', $folder, @_) }

# The files of one cloud at so many bits: its Draco, that decoded, and that denoised.
sub paths { my ($bits) = @_; return map { "$out/codec$bits.$_" } 'drc', 'ply', 'denoised.ply' }

# Codes the cloud at every number of bits: bytes by bits.
sub code {
    my ($cloud) = @_;
    my %bytes;
    for my $bits (@bits, @finer) {
        my ($drc, $decoded) = paths($bits);
        must('draco_encoder', '-point_cloud', '-i', $cloud, '-o', $drc, '-qp', $bits, '-cl', 10);
        must('draco_decoder', '-i', $drc, '-o', $decoded);
        $bytes{$bits} = -s $drc;
    }
    return %bytes;
}

# Denoises what was coded at the table's numbers of bits, as a user of the codec would: the runs by bits.
sub denoise {
    my %runs;
    for my $bits (@bits) {
        my ($drc, undef, $denoised) = paths($bits);
        $runs{$bits} = [map { process('denoise', $drc, $denoised, '--threads', 1) } 1 .. runs()];
    }
    return %runs;
}

# Distances from the mesh, decoded and denoised, and points that share a place: by bits.
sub distances {
    my ($mesh) = @_;
    my @decoded = map { (paths($_))[1] } @bits, @finer;
    my @lines = python('off', $mesh, @decoded, map { (paths($_))[2] } @bits);
    my (%off, %shared, %denoised);
    ($off{$_}, $shared{$_}) = split ' ', shift @lines for @bits, @finer;
    ($denoised{$_}) = split ' ', shift @lines for @bits;
    return (\%off, \%denoised, \%shared);
}

# Bytes with which decoding alone is as near, by the logarithm of the distance between two numbers of bits; undef beyond the last.
sub bytes_for {
    my ($distance, $off, $bytes) = @_;
    my @all = (@bits, @finer);
    for my $i (1 .. $#all) {
        my ($a, $b) = @all[$i - 1, $i];
        next if $off->{$b} > $distance;
        my $share = log($off->{$a} / $distance) / log($off->{$a} / $off->{$b});
        return $bytes->{$a} + $share * ($bytes->{$b} - $bytes->{$a});
    }
    return undef;
}

my (@table, %saved);
for my $name (qw(igea armadillo cow)) {
    next unless wanted("codec_$name");
    my $mesh = public("${name}_mesh");
    if (my $absent = missing("codec_$name", $mesh, yardstick())) {
        push @table, $absent;
        next;
    }
    my $cloud = "$out/codec.cloud.ply";
    python('sample', $mesh, $points, $cloud);
    my %bytes = code($cloud);
    my %runs = denoise();
    my ($off, $denoised, $shared) = distances($mesh);
    for my $bits (@bits) {
        my $alone = bytes_for($denoised->{$bits}, $off, \%bytes);
        my $saved = defined $alone ? 100 * (1 - $bytes{$bits} / $alone) : undef;
        push @{ $saved{$bits} }, $saved if defined $saved;
        push @table, [
            $name, $bits, $bytes{$bits}, $shared->{$bits}, map({ sprintf '%.2e', $_->{$bits} } $off, $denoised),
            defined $alone ? (sprintf('%.0f', $alone), sprintf('%.0f %%', $saved)) : ('-', '-'), spread('cpu', @{ $runs{$bits} }),
        ];
    }
    unlink $cloud, map { paths($_) } @bits, @finer;
}
exit 0 if !@table;
my @said = map { sprintf '%d bits %.0f to %.0f %%', $_, (sort { $a <=> $b } @{ $saved{$_} })[0, -1] } grep { $saved{$_} } @bits;
table(['cloud', 'bits', 'bytes', 'in a place with others', 'off, decoded', 'off, denoised', 'bytes for that by decoding alone', 'saved', 'cpu s'],
    \@table, "$points points of each mesh, white noise by area, coded by Debian's draco_encoder (-cl 10) at so many bits a coordinate. off: rms "
    . 'distance of the points from the mesh over its diagonal, after decoding alone and after voronoid denoise of the Draco file, to as '
    . 'many points. bytes for that by decoding alone: between the two numbers of bits around it. '
    . 'Saved: ' . join(', ', @said) . '. Below 0, the points that a fit puts on a white noise of samples lie farther off than the cells are wide.');
finish('codec');
