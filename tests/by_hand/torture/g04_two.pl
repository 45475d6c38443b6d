#!/usr/bin/perl
# A second daemon on the same store, and a start after kill -9.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Time::HiRes qw(time);
use Faults;
use Vt;

my %option = options();
my $daemon = Vt->start;
my $began = time;
my ($exit, $said) = Vt::run('--listen', '127.0.0.1:0', '--data', "$daemon->{dir}/data");
figure('G04', 'exit status of a second daemon on the store', $exit, 75);
figure('G04', 'time until it has ended', sprintf('%.2f s', time - $began), '1 s at most', time - $began <= 1);
figure('G04', 'what it says', $said =~ s/\s+$//r =~ s{/\S+/}{}gr, "names process $daemon->{pid}", $said =~ /process $daemon->{pid}\b/);
$daemon->stop('KILL');
my $again = eval { Vt->start(dir => $daemon->{dir}) };
figure('G04', 'a start after kill -9', $again ? 'listens' : $@, 'listens');
figure('G04', 'its exit status', $again ? $again->stop : 'none', 0);
