#!/usr/bin/perl
# usage: g22_cancel.pl [--long] [--seed N]: jobs of 1,000,000 points are cancelled at random moments, some while they insert.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support";
use Getopt::Long;
use JSON::PP;
use Time::HiRes qw(time sleep);
use Vt;

my ($long, $seed) = (0, 1);
GetOptions('long' => \$long, 'seed=i' => \$seed) or die "usage: g22_cancel.pl [--long] [--seed N]\n";
srand $seed;

# A bumpy sphere, whose points follow a spiral, as binary PLY.
sub cloud {
    my ($n) = @_;
    my $body = '';
    for my $i (0 .. $n - 1) {
        my $z = 1 - (2 * $i + 1) / $n;
        my $r = sqrt(1 - $z * $z);
        my $angle = 2.399963229728653 * $i;
        my $bump = 1 + 0.1 * sin(5 * $z);
        $body .= pack 'f<3', $bump * $r * cos $angle, $bump * $r * sin $angle, $bump * $z;
    }
    return "ply\nformat binary_little_endian 1.0\nelement vertex $n\nproperty float x\nproperty float y\nproperty float z\nend_header\n$body";
}

sub row {
    my ($what, $figure, $wanted, $is_ok) = @_;
    print join("\t", 'G22', $what, $figure, $wanted, $is_ok ? 'ok' : 'short'), "\n";
}

my ($cancels, $most) = $long ? (50, 15) : (5, 1.2);
my $daemon = Vt->start(jobs => 1);
my $body = cloud(1_000_000);
my (@told, @freed);
for (1 .. $cancels) {
    my $id = $daemon->submit('points=200000', $body);
    wait_until(sub { $daemon->status($id) eq 'running' }, 30) or die "job $id does not begin";
    sleep rand $most;
    my $began = time;
    json($daemon->request('DELETE', "/v1/jobs/$id"))->{status} eq 'dismissed' or die "job $id is not dismissed";
    push @told, time - $began;
    wait_until(sub { grep { $_->{msg} eq 'job ended' && $_->{job} eq $id } $daemon->log_lines }, 30) or die "job $id does not end";
    push @freed, time - $began;
}

# A million points inserted one by one, cancelled in the middle of it.
my $inserting = $long ? 20 : 1;
my $fewer = cloud(65_000);
my (@told_inserting, @freed_inserting);
for (1 .. $inserting) {
    my $id = $daemon->submit('points=1000000&method=ear&samples=22000', $fewer);
    wait_until(sub { ((json($daemon->get("/v1/jobs/$id"))->{voronoid}{metrics} // {})->{run_stage} // '') eq 'insert' }, 120)
        or die "job $id does not insert";
    sleep rand($long ? 3 : 0.3);
    my $began = time;
    json($daemon->request('DELETE', "/v1/jobs/$id"))->{status} eq 'dismissed' or die "job $id is not dismissed";
    push @told_inserting, time - $began;
    wait_until(sub { grep { $_->{msg} eq 'job ended' && $_->{job} eq $id } $daemon->log_lines }, 30) or die "job $id does not end";
    push @freed_inserting, time - $began;
}
my $ended = grep { $_->{msg} eq 'worker ended' } $daemon->log_lines;
my $exit = $daemon->stop;

sub p99 { my @sorted = sort { $a <=> $b } @_; return $sorted[0.99 * $#sorted + 0.5] }

row('cancel at 1 M points: dismissed after, p99', sprintf('%.0f ms of %d', 1000 * p99(@told), $cancels), '<= 200 ms', p99(@told) <= 0.2);
row('its cores are free after, slowest', sprintf('%.0f ms', 1000 * p99(@freed)), '<= 2000 ms', p99(@freed) <= 2);
row('cancel in the middle of a million insertions: dismissed after, p99', sprintf('%.0f ms of %d', 1000 * p99(@told_inserting), $inserting),
    '<= 200 ms', p99(@told_inserting) <= 0.2);
row('its cores are free after, slowest', sprintf('%.0f ms', 1000 * p99(@freed_inserting)), '<= 2000 ms', p99(@freed_inserting) <= 2);
row('workers that had to be killed for it; exit status', "$ended, $exit", '0, 0', $ended == 0 && $exit eq '0');
