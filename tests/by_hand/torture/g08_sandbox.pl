#!/usr/bin/perl
# G8 and G29's sandbox: the test build of the codec child tries what it may not, as root and as nobody; and a daemon without
# root, capabilities and new privileges has the whole sandbox.
use strict;
use warnings;
use FindBin;
use Getopt::Long;
use lib "$FindBin::Bin/../../support";
use Vt;

GetOptions('long' => \my $long, 'seed=i' => \my $seed) or exit 2;
my $program = 'build/release/tests/unit/sandbox_test';
system("make -s $program >&2") == 0 or die "cannot build $program";
my @lines = grep { /whatever_a_child_may_not_do/ } split /\n/, `$program 2>/dev/null`;
my $held = grep { /^ok/ } @lines;
printf "G8\topen, socket, execve, fork, kill, ptrace, write, loop, allocate and 5 more: stopped and told, as root and as nobody\t%s\tboth\t%s\n",
    $held == 2 ? 'both' : "$held of 2", $held == 2 ? 'ok' : 'short';

my $binary = $ENV{VORONOID} // 'build/release/voronoid';
my $dir = File::Temp::tempdir(CLEANUP => 1);
chmod 0777, $dir;
system("cp $binary $dir/voronoid && chmod 755 $dir/voronoid") == 0 or die;
my @plain = $> == 0 ? qw(setpriv --reuid 65534 --regid 65534 --clear-groups --no-new-privs --inh-caps=-all --bounding-set=-all) : ();
my $pid = fork // die;
if (!$pid) {
    open STDERR, '>', "$dir/log";
    open STDIN, '<', '/dev/null';
    exec @plain, "$dir/voronoid", 'serve', '--listen', '127.0.0.1:0', '--data', "$dir/data" or POSIX::_exit(127);
}
my $address = wait_until(sub { Vt::slurp("$dir/log") =~ /"address":"([^"]+)"/ ? $1 : undef }, 20);
my $sandbox = 'none';
if ($address) {
    my $http = HTTP::Tiny->new(timeout => 20);
    $sandbox = json($http->get("http://$address/readyz"))->{sandbox};
    my $answer = $http->post("http://$address/v1/convert", { content => sphere_ply(100) });
    $sandbox .= ", but an upload got $answer->{status}" if $answer->{status} != 200;
}
kill 'TERM', $pid;
waitpid $pid, 0;
printf "G29\tsandbox of a daemon with uid 65534, no capabilities, no new privileges\t%s\tfull\t%s\n", $sandbox, $sandbox eq 'full' ? 'ok' : 'short';
