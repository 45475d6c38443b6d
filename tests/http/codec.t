#!/usr/bin/perl
# Uploads are read by children of the daemon: what they leave behind, whoever ends them, and what is told of them.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $daemon = Vt->start;
my $cloud = sphere_ply(300);
my $run = '/v1/resample?points=50&iterations=0&polish=0';

# Processes below one, as [pid, name].
sub below {
    my ($pid) = @_;
    my @found;
    for my $stat (glob '/proc/[0-9]*/stat') {
        my ($child, $name, $parent) = Vt::slurp($stat) =~ /^(\d+) \((.*)\) \S (\d+)/ or next;
        push @found, [$child, $name], below($child) if $parent == $pid;
    }
    return @found;
}
sub names_below { return join ' ', sort map { $_->[1] } below($_[0]) }

is names_below($daemon->{pid}), 'vor-worker vor-zygote', 'beside the worker the daemon has one child, which does nothing';
like json($daemon->get('/readyz'))->{sandbox}, qr/\A(?:full|partial)\z/, 'readiness tells what uploads are read in';
is $daemon->post($run, $cloud)->{status}, 200, 'an upload is read';
ok wait_until(sub { names_below($daemon->{pid}) eq 'vor-worker vor-zygote' }), 'and the child that has read it is gone';

# Draco with bytes behind it.
my $draco = $daemon->post('/v1/convert?format=drc', $cloud)->{content};
my $padded = $daemon->post('/v1/convert', $draco . "\0" x 7);
is $padded->{status}, 200, 'a Draco stream may be padded';
my $more = $daemon->post('/v1/convert', $draco . "\0" x 8);
is_problem($more, 422, 'undecodable-cloud', 'more bytes behind it are refused');
like json($more)->{detail}, qr/ends after @{[length $draco]} of @{[8 + length $draco]} bytes/, 'with their place';

# A caller who leaves while its upload is read: 20 MB of digits take a second and more.
my $line = join(' ', ('0.12345678901234567890') x 3) . "\n";
my $large = "ply\nformat ascii 1.0\nelement vertex 400000\nproperty double x\nproperty double y\nproperty double z\nend_header\n"
    . $line x 300_000;
my $socket = $daemon->connect;
print $socket "POST $run HTTP/1.1\r\nHost: localhost\r\nContent-Length: " . length($large) . "\r\n\r\n$large";
$socket->flush;
ok wait_until(sub { names_below($daemon->{pid}) =~ /vor-codec/ }), 'a child reads a large upload';
close $socket;
ok wait_until(sub { names_below($daemon->{pid}) eq 'vor-worker vor-zygote' }), 'and ends with its caller';

# SIGKILL of the daemon.
my @left = map { $_->[0] } below($daemon->{pid});
my $dir = $daemon->{dir};
$daemon->stop('KILL');
ok wait_until(sub { !grep { -e "/proc/$_" && Vt::slurp("/proc/$_/stat") !~ /\) Z / } @left }), 'a daemon that is killed leaves no process';
$daemon = do { local $SIG{CHLD} = 'IGNORE'; Vt->start(dir => $dir) }; # as some supervisors have it
is $daemon->post($run, $cloud)->{status}, 200, 'nor a lock: the next one starts at once';

# Without the zygote no upload can be read.
kill 'KILL', (below($daemon->{pid}))[0][0];
is Vt::reap(delete $daemon->{pid}), 1, 'a daemon whose zygote is killed ends as failed';
like $daemon->log_text, qr/the process that starts the decoders of uploads has ended/, 'and says why';
done_testing;
