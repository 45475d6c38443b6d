#!/usr/bin/perl
# order=progressive from the command line and over HTTP, in both formats.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use HTTP::Tiny;
use JSON::PP;
use Test::More;

my $folder = scratch();
my $in = spew("$folder/in.ply", sphere(4000));
my $points = 1000;
my @request = ('-n', $points, '--iterations', 6, '--polish', 10);

# Rows of a result, in the order of the file: all here have the same size.
sub rows {
    my ($ply) = @_;
    my ($header, $body) = $ply =~ /\A(ply\n.*?end_header\n)(.*)\z/s;
    my $size = length($body) / $points;
    return map { substr $body, $_ * $size, $size } 0 .. $points - 1;
}

sub resampled {
    my ($name, @with) = @_;
    my ($code, undef, $stderr) = run(['resample', $in, @request, '-q', '-fo', "$folder/$name", @with]);
    is "$code|$stderr", '0|', "$name is there";
    return slurp("$folder/$name");
}

# The delta and the spacing of the first points of a result, as measured.
sub first {
    my ($ply, $count) = @_;
    my ($header) = $ply =~ /\A(ply\n.*?end_header\n)/s;
    my @rows = (rows($ply))[0 .. $count - 1];
    $header =~ s/^element vertex \d+/element vertex $count/m;
    my ($code, $json) = run(['measure', spew("$folder/first.ply", $header . join '', @rows)]);
    is $code, 0, "the first $count are a cloud";
    return decode_json($json);
}

my $spatial = resampled('spatial.ply');
my $progressive = resampled('progressive.ply', '--order', 'progressive');

ok resampled('named.ply', '--order', 'spatial') eq $spatial, 'spatial is the default';
ok $progressive ne $spatial, 'progressive is another order';
is join('', sort(rows($progressive))), join('', sort(rows($spatial))), 'of the same points';

# Ideal spacing goes by the square root: four times as many points are half as far apart.
my $whole = first($progressive, $points);
my $early = first($progressive, $points / 20);
cmp_ok $early->{mean_nn}, '>', 0.7 * sqrt(20) * $whole->{mean_nn}, 'the first twentieth is far apart';
cmp_ok $early->{delta}, '<', 0.15, 'and even';
cmp_ok first($spatial, $points / 20)->{mean_nn}, '<', 2 * $whole->{mean_nn}, 'which in spatial order it is not';

# Byte 8 of a Draco file is the encoding: 0 keeps the order, 1 is the kd-tree.
is ord(substr resampled('spatial.drc'), 8), 1, 'Draco packs the spatial order into a kd-tree';
is ord(substr resampled('progressive.drc', '--order', 'progressive'), 8), 0, 'the progressive one is kept';

my ($code, undef, $stderr) = run(['resample', $in, @request, '-fo', "$folder/no.ply", '--order', 'random']);
is "$code|$stderr", "2|voronoid: resample: order is \"random\", want one of spatial, progressive\n", 'there is no other';

my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);
my $http = HTTP::Tiny->new(timeout => 120);
my $query = "points=$points&iterations=6&polish=10";
for my $format (qw(ply drc)) {
    my $answer = $http->post("$daemon->{url}/v1/resample?$query&order=progressive&format=$format", { content => slurp($in) });
    is $answer->{status}, 200, "$format over HTTP";
    ok $answer->{content} eq slurp("$folder/progressive.$format"), 'has the same bytes';
}
my $refusal = $http->post("$daemon->{url}/v1/resample?$query&order=3", { content => slurp($in) });
is $refusal->{status}, 400, 'what is no order is refused';
like decode_json($refusal->{content})->{detail}, qr/order is "3", want one of spatial, progressive/, 'by name';
is((stop($daemon))[0], 0, 'the daemon ends well');
done_testing();
