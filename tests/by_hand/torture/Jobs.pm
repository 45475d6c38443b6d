package Jobs;

# What the rows about jobs share: their options, the line of a figure, a few helpers.
use strict;
use warnings;
use Exporter 'import';
use FindBin;
use lib "$FindBin::Bin/../../support";
use Sockets;
use Time::HiRes qw(time);
use Vt;

our @EXPORT = qw(figure percentile async cloud_ply random_points outcome $long $seed);
our ($long, $seed) = Sockets::options();
*figure = \&Sockets::row;
*percentile = \&Sockets::percentile;

# Submits; the answer, and the seconds until it came.
sub async {
    my ($daemon, $query, $body) = @_;
    my $began = time;
    my $answer = $daemon->post("/v1/$query", $body, Prefer => 'respond-async');
    return ($answer, time - $began);
}

# A binary PLY of points [x, y, z].
sub cloud_ply {
    my (@points) = @_;
    return "ply\nformat binary_little_endian 1.0\nelement vertex " . @points
        . "\nproperty float x\nproperty float y\nproperty float z\nend_header\n" . join '', map { pack 'f<3', @$_ } @points;
}

sub random_points { return map { [rand, rand, rand] } 1 .. $_[0] }

# The status of a job that is over, with its message where it failed.
sub outcome {
    my ($daemon, $id) = @_;
    my $info = $daemon->finish($id);
    return $info->{status} eq 'failed' ? "failed: $info->{message}" : $info->{status};
}

1;
