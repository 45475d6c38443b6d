#!/usr/bin/perl
# usage: clocked.pl FILE TEST: runs a test, and adds to FILE a line with its seconds of CPU and by the clock.
use strict;
use warnings;
use Time::HiRes qw(time);

my ($file, @test) = @ARGV;
my $began = time;
system { $test[0] } @test;
my $status = $?;
my (undef, undef, $user, $system) = times;
open my $times, '>>', $file or die "$file: $!";
printf $times "%8.2f %8.2f  %s\n", $user + $system, time - $began, $test[-1];
close $times;
die "$test[0]: $!" if $status == -1;
exit($status & 127 ? 128 + ($status & 127) : $status >> 8);
