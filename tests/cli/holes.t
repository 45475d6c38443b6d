#!/usr/bin/perl
# Holes on the command line, here and by a daemon: inspect tells their numbers, resample fills them, and its report what
# stayed open.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use JSON::PP;
use Test::More;

my $folder = scratch();
my ($head, $points) = split /(?<=end_header\n)/, sphere(3000);
my @kept = grep { my $z = (split)[2]; $z < 0.96 && $z > -0.94 } split /\n/, $points;
$head =~ s/vertex \d+/"vertex " . @kept/e;
my $in = spew("$folder/in.ply", $head . join("\n", @kept) . "\n");
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);
my @fill = ('resample', $in, '-fo', "$folder/out.ply", '-n', 1000, '--iterations=2', '--polish=0', '--boundary=fill', '--json');

my $told = decode_json((run(['inspect', $in, '--json']))[1]);
is_deeply [map { $_->{kind} } @{ $told->{loops} }], [qw(hole hole)], 'inspect tells two holes';
for my $server ([], ['--server', $daemon->{url}]) {
    my $where = @$server ? 'there' : 'here';
    my ($code, $stdout, $stderr) = run([@fill, @$server]);
    is "$code$stderr", '0', "$where: all is well";
    my $holes = last_report($stdout)->{holes};
    is_deeply [@$holes{qw(loops filled not_closed)}], [2, 2, 0], "$where: both are filled by default";
    is_deeply [map { $_->{id} } @{ $holes->{each} }], [1, 2], "$where: with the numbers that inspect tells";
    is $holes->{each}[$_]{length}, $told->{loops}[$_]{length}, "$where: hole $_ has its length" for 0, 1;
    is $holes->{points}, $holes->{each}[0]{points} + $holes->{each}[1]{points}, "$where: their points are counted";
    my $one = last_report((run([@fill, '--holes=2', @$server]))[1]);
    is_deeply [map { $_->{outcome} } @{ $one->{holes}{each} }], [qw(not-chosen filled)], "$where: or the one that is named";
    is_deeply $one->{parameters}{holes}, [2], "$where: the request tells its number";
    ($code, $stdout, $stderr) = run([@fill, '--holes=1,9', @$server]);
    isnt $code, 0, "$where: a number that none has is refused";
    like $stderr, qr/holes contains 9, but the border loops are numbered from 1 to 2; run inspect to list them/, "$where: with those there are";
}
my ($code, $stdout) = run(['inspect', "$folder/out.ply", '--json']);
is decode_json($stdout)->{border}{loops}, 1, 'the hole that was not named is the last one in the result';
is last_report((run([map { s/fill$/keep/r } @fill]))[1])->{holes}, undef, 'nothing is told of holes where none are asked for';

# The report of a run is the last line.
sub last_report {
    my ($lines) = @_;
    my $last = decode_json((split /\n/, $lines)[-1]);
    return $last->{report} // $last;
}
done_testing();
