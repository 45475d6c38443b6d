#!/usr/bin/perl
# --metric lp, --cells euclid and --moveStop, here and by a daemon of our own: the same points, and a report that says how it went.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use JSON::PP;
use Test::More;

my $folder = scratch();
my @points = map { my $i = $_; map { my $turn = 6.2831853 * ($_ + ($i % 2) / 2) / 40; [cos $turn, sin $turn, $i / 8] } 0 .. 39 } 0 .. 24;
my $tube = spew("$folder/tube.ply", "ply\nformat ascii 1.0\nelement vertex " . @points
    . "\nproperty float x\nproperty float y\nproperty float z\nend_header\n" . join('', map { "@$_\n" } @points));
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);
my %result;

for my $where ([], ['--server', $daemon->{url}]) {
    my $by = @$where ? 'by a daemon' : 'here';
    my $out = "$folder/out.ply";
    my $ask = sub {
        my ($name, @options) = @_;
        my ($code, $stdout, $stderr) = run(['resample', $tube, '-n', 100, '-fo', $out, '--json', @options, @$where]);
        is "$code$stderr", '0', "a tube is resampled with @options, $by";
        push @{ $result{$name} }, slurp($out);
        return decode_json((split /\n/, $stdout)[-1]);
    };

    my $report = $ask->('lp', '--metric', 'lp');
    is_deeply [@$report{qw(iterations polish_steps stopped)}], [35, 0, 'iterations'], "it is 35 iterations and no polish, $by";
    cmp_ok $report->{descent}{steps}, '>', 35, "of more than a step, $by";
    cmp_ok $report->{descent}{evaluations}, '>', $report->{descent}{steps}, "with an evaluation each, $by";
    cmp_ok $report->{descent}{worst}, '<', 1, "that lower the energy, $by";
    cmp_ok $report->{descent}{aspect}, '>=', 1, "and cells have an aspect, $by";
    is_deeply [@{ $report->{parameters} }{qw(metric p cells)}], ['lp', 8, 'metric'], "the report says what was asked for, $by";

    ok exists $ask->('euclid', '--cells', 'euclid', '--iterations', 3)->{descent}, "so it is with Euclidean cells, $by";
    $report = $ask->('still', '--moveStop', 1, '--polish', 2);
    is_deeply [@$report{qw(iterations polish_steps stopped)}], [1, 2, 'moveStop'], "a move ends the iterations, not the polish, $by";
    ok !exists $report->{descent}, "without an energy there is nothing to say of one, $by";
    my ($code, $stdout, $stderr) = run(['resample', $tube, '-n', 100, '-fo', $out, '--metric', 'lp', '--p', 7, @$where]);
    is $code, 2, "an odd power is refused, $by";
    like $stderr, qr/\Avoronoid: .*p is 7, want an even number from 2 to 8\n\z/, "with the range, $by";
}
is $result{$_}[0], $result{$_}[1], "$_: here and there the same bytes" for sort keys %result;
isnt $result{lp}[0], $result{euclid}[0], 'a power of eight puts points elsewhere than a power of two';
done_testing;
