#!/usr/bin/perl
# Draco results as npm's draco3d decodes them in a page: positions plus the origin of the metadata are ours. CONTRACT is
# the folder with draco3d.js beside the packages of package.json (npm ci); without it, this one.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../cli", "$FindBin::Bin/../support";
use Cli;
use Frame;
use Test::More;

my $dir = scratch();
my $decoder = ($ENV{CONTRACT} // $FindBin::Bin) . '/draco3d.js';

sub decode {
    my ($file, $out, $name, $origin) = @_;
    my $told = `node $decoder $file $out 2>$dir/log`;
    is $?, 0, "$name: draco3d decodes it" or diag slurp("$dir/log");
    is $told, "$origin\n", "$name: and reads its origin";
}

my @clouds = clouds($dir);
plan skip_all => 'no ../shared/data' unless @clouds;
for my $order ('spatial', 'progressive') { compare($dir, $_, $order, \&decode) for @clouds }
done_testing;
