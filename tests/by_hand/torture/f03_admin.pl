#!/usr/bin/perl
# The second listener beside a first one that silent connections have exhausted: /livez and /metrics, asked 20 times.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support";
use Getopt::Long;
use Time::HiRes qw(time);
use Vt;

my ($long, $seed) = (0, 1);
GetOptions('long' => \$long, 'seed=i' => \$seed) or exit 2;
$| = 1;

sub row { my ($what, $figure, $wanted, $holds) = @_; print join("\t", 'F03', $what, $figure, $wanted, $holds ? 'ok' : 'short'), "\n" }
sub files { return 0 + `prlimit --pid $$ --nofile --output SOFT --noheadings` }

sub measure {
    my ($silent, $where, $daemon) = @_;
    my ($admin) = map { $_->{admin} // () } $daemon->log_lines;
    my @silent = map { $daemon->connect } 1 .. $silent;
    my ($missed, @took) = (0);
    for my $n (1 .. 20) {
        my $began = time;
        my $answer = HTTP::Tiny->new(timeout => 1)->get("http://$admin/" . ($n % 2 ? 'livez' : 'metrics'));
        $answer->{status} == 200 ? push @took, time - $began : $missed++;
    }
    @took = sort { $a <=> $b } @took, 9;
    row("$silent silent connections $where: admin listener, missed of 20", $missed, 0, $missed == 0);
    row("$silent silent connections $where: admin listener, slowest", sprintf('%.1f ms', 1e3 * $took[-2]), '100 ms at most',
        @took > 1 && $took[-2] <= 0.1);
    $daemon->stop;
}

measure(400, 'of 64 allowed', Vt->start('admin-listen' => '127.0.0.1:0', connections => 64));

# A daemon that is started with so many open files allowed; ours are as before afterwards.
sub limited {
    my ($files, $do) = @_;
    my $before = files();
    system('prlimit', '--pid', $$, "--nofile=$files:") == 0 or die "prlimit: $?";
    my $daemon = $do->();
    system('prlimit', '--pid', $$, "--nofile=$before:") == 0 or die "prlimit: $?";
    return $daemon;
}

system('prlimit', '--pid', $$, '--nofile=4096:') if files() < 4096;
for my $silent (1100, $long ? 2300 : ()) {
    if (files() < $silent + 100) {
        print STDERR "only ", files(), " files may be open here\n";
        next;
    }
    my $start = sub { Vt->start('admin-listen' => '127.0.0.1:0') };
    measure($silent, 'under a limit of 1,024 files', limited(1024, $start)) if $silent == 1100;
    measure($silent, 'under any limit', $start->());
}
